// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "localiser/localiser.h"
#include "mapping/store/map_directory.h"
#include "session/server/server.h"

namespace waymark::session {

/// Answers images with a localiser of the map.
using MakeLocalise =
    std::function<LocaliseFunction(std::shared_ptr<const localiser::Localiser> localiser)>;

/// Looks once a second which release of a map is live, and takes the server over to it. The old one
/// is served until the new one is open; one that cannot be opened is logged and left alone until
/// another goes live.
class ReleaseWatcher {
 public:
  /// Borrows the server. `localiser` serves the release that is live now.
  ReleaseWatcher(mapping::MapDirectory map, std::shared_ptr<const localiser::Localiser> localiser,
                 MakeLocalise make_localise, Server& server);
  ReleaseWatcher(const ReleaseWatcher&) = delete;
  ReleaseWatcher& operator=(const ReleaseWatcher&) = delete;
  ~ReleaseWatcher();

 private:
  void Watch();
  Result<void> GoOver(std::uint64_t epoch);

  const mapping::MapDirectory map_;
  std::shared_ptr<const localiser::Localiser> localiser_;  // owned by the thread
  const MakeLocalise make_localise_;
  Server& server_;
  std::uint64_t last_epoch_;  // seen, served or not; owned by the thread
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_stopping_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace waymark::session

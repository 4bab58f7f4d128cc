// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "content_store/anchor_store.h"
#include "session/server/anchor_support.h"

namespace waymark::session {

/// Looks after all anchors of a store on a thread of its own, whether their room is open or not:
/// deletes what has expired, and after each change of the release renews the attachments of those
/// that lost submaps. What it writes reaches open rooms by the store's change feed. Several servers
/// may do so on one store: who comes second finds it done.
class AnchorKeeper {
 public:
  /// Borrows the store. `load` reads earlier releases; without it an anchor whose submaps all went
  /// while no server ran is unsupported.
  AnchorKeeper(content::AnchorStore& store, const TangentPlane& map_plane,
               std::shared_ptr<const LiveRelease> live, LoadRelease load = {});
  AnchorKeeper(const AnchorKeeper&) = delete;
  AnchorKeeper& operator=(const AnchorKeeper&) = delete;
  ~AnchorKeeper();  ///< as Finish

  void SetRelease(std::shared_ptr<const LiveRelease> live);
  /// Returns when what it is about, one room at most, is done.
  void Finish();

 private:
  /// Going through the rooms once for a release.
  struct Round {
    ReleaseHistory releases;
    std::deque<RoomId> rooms = {};  // still to do
    bool has_begun = false;         // the rooms are known
    std::size_t renewed = 0;
    std::size_t unsupported = 0;
  };

  void Work();
  bool Advance(Round& round);
  Result<void> Renew(const RoomId& room, Round& round);

  content::AnchorStore& store_;
  const TangentPlane map_plane_;
  const LoadRelease load_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<const LiveRelease> live_, before_;  // guarded by mutex_
  bool is_new_release_ = true;                        // guarded by mutex_
  bool is_finishing_ = false;                         // guarded by mutex_
  std::thread thread_;
};

}  // namespace waymark::session

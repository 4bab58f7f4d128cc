// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

#include "content_store/anchor_store.h"
#include "session/state/events.h"

namespace waymark::session {

/// Tells what changes in a store from now on, whoever writes it: other servers, tools, expiry, and
/// this server itself. On a thread of its own.
class StoreFollower {
 public:
  /// Borrows the store. What is read from it after this is no older than where the feed begins.
  StoreFollower(content::AnchorStore& store, std::function<void(event::StoreChanged)> report);
  StoreFollower(const StoreFollower&) = delete;
  StoreFollower& operator=(const StoreFollower&) = delete;
  ~StoreFollower();  ///< as Finish

  /// Reports no more when it returns.
  void Finish();

 private:
  void Follow();
  bool Report(std::uint64_t latest);

  content::AnchorStore& store_;
  const std::function<void(event::StoreChanged)> report_;
  std::uint64_t told_ = 0;   // used by the thread, once it runs
  bool is_failing_ = false;  // as told_
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_finishing_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace waymark::session

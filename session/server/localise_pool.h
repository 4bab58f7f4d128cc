// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "mapping/base/result.h"
#include "session/state/messages.h"

namespace waymark::session {

/// Answers one image. Called on several threads at once. An error is the image's fault.
using LocaliseFunction = std::function<Result<localiser::Localisation>(const LocaliseQuery&)>;

struct LocalisePoolOptions {
  int threads = 1;             ///< [1, 256]
  std::size_t max_queue = 16;  ///< >= 1; beyond this devices are told "busy"
  /// An image that would have to wait longer, or has, is refused as "busy", >= 0. Phones give up
  /// after 5 s.
  std::chrono::duration<double> max_wait{3.0};

  Result<void> Validate() const;
};

/// Localises on a few threads. A device's newer image replaces its older one in the queue. What
/// cannot be answered in time is answered "busy" at once rather than late: the queue is full, or,
/// as long as recent images took, would not be through. Thread-safe.
class LocalisePool {
 public:
  /// `deliver` is called from the pool's threads and, for refusals, from Submit.
  LocalisePool(const LocalisePoolOptions& options, LocaliseFunction localise,
               std::function<void(LocaliseAnswer)> deliver);
  LocalisePool(const LocalisePool&) = delete;
  LocalisePool& operator=(const LocalisePool&) = delete;
  ~LocalisePool();  ///< finishes what is under way, drops the queue

  void Submit(const DeviceId& device, LocaliseQuery query);
  /// Images taken up from now on are answered by this.
  void SetLocalise(LocaliseFunction localise);

 private:
  struct Job {
    DeviceId device;
    LocaliseQuery query;
    std::chrono::steady_clock::time_point arrived;
  };

  void Work();
  bool HasRoom() const;  // mutex_ is held
  LocaliseAnswer Answer(const Job& job, const LocaliseFunction& localise) const;
  void Refuse(const Job& job, const char* reason) const;

  const LocalisePoolOptions options_;
  const std::function<void(LocaliseAnswer)> deliver_;
  std::mutex mutex_;
  std::shared_ptr<const LocaliseFunction> localise_;  // guarded by mutex_
  std::condition_variable changed_;
  std::deque<Job> queue_;     // guarded by mutex_
  double service_s_ = 0;      // of recent images, each weighs an eighth; guarded by mutex_
  bool is_stopping_ = false;  // guarded by mutex_
  std::vector<std::thread> threads_;
};

}  // namespace waymark::session

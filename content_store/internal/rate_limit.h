// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <unordered_map>

#include "content_store/anchor_store.h"

namespace waymark::content::internal {

/// How fast each owner writes: a bucket of `max_burst` writes that refills at
/// `max_writes_per_second`. Forgets owners whose bucket is full again. Thread-compatible.
class RateLimit {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit RateLimit(const StoreLimits& limits) : limits_(limits) {}

  /// Takes one write from the owner's bucket. Errors: Unavailable, saying when to try again.
  Result<void> Admit(const std::string& owner, Time now);

  /// Puts back what Admit took for a write that is tried again.
  void Return(const std::string& owner);

  std::size_t remembered() const { return buckets_.size(); }

 private:
  struct Bucket {
    double level = 0;
    Time filled;
  };

  void Forget(Time now);
  double LevelAt(const Bucket& bucket, Time now) const;

  const StoreLimits limits_;
  std::unordered_map<std::string, Bucket> buckets_;
  std::size_t forget_at_ = 1024;
};

}  // namespace waymark::content::internal

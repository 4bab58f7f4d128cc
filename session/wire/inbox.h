// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace waymark::session {

/// Where other threads leave things for the one loop that owns the state. Bounded by count and by
/// weight, so that no peer can fill the memory. Thread-safe.
template <typename Item>
class Inbox {
 public:
  Inbox(std::size_t max_items, std::size_t max_bytes)
      : max_items_(max_items), max_bytes_(max_bytes) {}

  /// Whether an item is taken at once, or with the next one or at the deadline.
  enum class Urgency { kAtOnce, kCanWait };

  /// Leaves an item that weighs `bytes` beyond its own size. False, and dropped: full.
  bool TryPush(Item item, std::size_t bytes, Urgency urgency = Urgency::kAtOnce) {
    const std::lock_guard lock(mutex_);
    if (items_.size() >= max_items_ || bytes_ + bytes > max_bytes_) {
      ++dropped_;
      return false;
    }
    items_.push_back(std::move(item));
    bytes_ += bytes;
    if (urgency == Urgency::kAtOnce) changed_.notify_one();
    return true;
  }

  /// For what we ourselves produce, which is bounded elsewhere: always taken.
  void Push(Item item) {
    const std::lock_guard lock(mutex_);
    items_.push_back(std::move(item));
    changed_.notify_one();
  }

  /// Wakes a waiting TakeAll and every later one.
  void Close() {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
    changed_.notify_all();
  }

  /// Everything there is, in order, waiting for something until the deadline.
  std::vector<Item> TakeAll(std::chrono::steady_clock::time_point deadline) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, deadline, [this] { return !items_.empty() || is_closed_; });
    bytes_ = 0;
    return std::exchange(items_, {});
  }

  std::uint64_t DroppedItems() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  const std::size_t max_items_;
  const std::size_t max_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Item> items_;    // guarded by mutex_
  std::size_t bytes_ = 0;      // guarded by mutex_
  std::uint64_t dropped_ = 0;  // guarded by mutex_
  bool is_closed_ = false;     // guarded by mutex_
};

}  // namespace waymark::session

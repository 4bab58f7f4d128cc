// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

namespace waymark::session::c {

/// What the app holds by number. Numbers are never used twice, and no number of one table is one of
/// another of a different kind. Who found an object keeps it while using it, so that it may be
/// removed meanwhile. Thread-safe.
template <typename Object>
class HandleTable {
 public:
  /// Kind in [0, 15].
  explicit HandleTable(std::uint64_t kind) : next_(16 + kind) {}

  std::uint64_t Add(std::shared_ptr<Object> object) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t handle = next_;
    next_ += 16;
    objects_.emplace(handle, std::move(object));
    return handle;
  }

  /// Nothing when there is none of that number.
  std::shared_ptr<Object> Find(std::uint64_t handle) const {
    const std::lock_guard lock(mutex_);
    const auto found = objects_.find(handle);
    return found == objects_.end() ? nullptr : found->second;
  }

  std::shared_ptr<Object> Remove(std::uint64_t handle) {
    const std::lock_guard lock(mutex_);
    const auto found = objects_.find(handle);
    if (found == objects_.end()) return nullptr;
    std::shared_ptr<Object> removed = std::move(found->second);
    objects_.erase(found);
    return removed;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::uint64_t, std::shared_ptr<Object>> objects_;  // guarded by mutex_
  std::uint64_t next_;                                        // guarded by mutex_
};

}  // namespace waymark::session::c

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <type_traits>
#include <utility>
#include <vector>

#include "content_store/internal/anchor_tables.h"

namespace waymark::content::internal {

/// Connections of which each serves one caller at a time. One that failed is not trusted again.
/// Thread-safe.
class ConnectionPool {
 public:
  explicit ConnectionPool(AnchorDatabase& database) : database_(database) {}

  /// Runs `action` on one consistent picture. After a lost connection it tries once more on a new
  /// one: reading twice does no harm.
  template <typename Action>
  std::invoke_result_t<Action, AnchorTables&> Read(Action&& action) {
    return Use([&](AnchorTables& tables) { return tables.Read([&] { return action(tables); }); });
  }

  /// Runs `action` without a transaction around it.
  template <typename Action>
  std::invoke_result_t<Action, AnchorTables&> Use(Action&& action) {
    for (bool is_first = true;; is_first = false) {
      WAYMARK_TRY_ASSIGN(auto tables, Borrow());
      auto result = tables->Guard([&] { return action(*tables); });
      const bool is_usable = tables->state() == ConnectionState::kUsable;
      if (result && is_usable) Return(std::move(tables));
      if (result || is_usable || !is_first) return result;
      Clear();  // the others have lost the same server
    }
  }

 private:
  Result<std::unique_ptr<AnchorTables>> Borrow() {
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        auto tables = std::move(idle_.back());
        idle_.pop_back();
        return tables;
      }
    }
    return database_.Connect();
  }
  void Return(std::unique_ptr<AnchorTables> tables) {
    constexpr std::size_t kMaxIdle = 8;  // file handles and page caches
    const std::lock_guard lock(mutex_);
    if (idle_.size() < kMaxIdle) idle_.push_back(std::move(tables));
  }
  void Clear() {
    const std::lock_guard lock(mutex_);
    idle_.clear();
  }

  AnchorDatabase& database_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<AnchorTables>> idle_;  // guarded by mutex_
};

}  // namespace waymark::content::internal

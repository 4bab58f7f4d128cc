// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace waymark::content {

/// Stands between this program and fsync/fdatasync: calls `before` with the path of every file
/// about to be synced, and fails the sync with EIO when it returns false. One at a time.
class SyncWatch {
 public:
  explicit SyncWatch(std::function<bool(const std::string& path)> before);
  SyncWatch(const SyncWatch&) = delete;
  SyncWatch& operator=(const SyncWatch&) = delete;
  ~SyncWatch();
};

}  // namespace waymark::content

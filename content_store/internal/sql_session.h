// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <type_traits>
#include <utility>

#include "content_store/anchor_store.h"
#include "mapping/base/result.h"

namespace waymark::content::internal {

/// One SQLite connection and the door at which its exceptions become errors. Thread-compatible.
class SqlSession {
 public:
  /// Opens the file, creating it if the mode says so, and brings its schema to the present version.
  /// Errors: NotFound, Unavailable, Corrupt, Unsupported.
  static Result<std::unique_ptr<SqlSession>> Open(const std::filesystem::path& file,
                                                  const SqliteStoreOptions& options);

  soci::session& sql() { return sql_; }
  const std::filesystem::path& file() const { return file_; }

  /// Runs `action`, which returns a Result and may throw what SOCI throws.
  template <typename Action>
  std::invoke_result_t<Action> Guard(Action&& action) {
    try {
      return std::forward<Action>(action)();
    } catch (const std::exception& exception) {
      return Describe(exception);
    }
  }

  /// Runs `action` on one consistent picture of the database.
  template <typename Action>
  std::invoke_result_t<Action> Read(Action&& action) {
    return Guard([&]() -> std::invoke_result_t<Action> {
      const soci::transaction transaction(sql_);  // rolled back at the end: nothing was written
      return action();
    });
  }

  /// Whether the latest failure was a sync to disk: what the disk then holds is not known.
  bool failed_to_sync();

 private:
  SqlSession(const std::filesystem::path& file, const std::string& connection);

  Error Describe(const std::exception& exception) const;

  std::filesystem::path file_;
  soci::session sql_;
};

}  // namespace waymark::content::internal

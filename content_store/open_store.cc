// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "content_store/anchor_store.h"
#include "content_store/internal/open_database.h"
#include "content_store/internal/postgres_tables.h"
#include "content_store/internal/sql_store.h"
#include "content_store/internal/sqlite_tables.h"

namespace waymark::content {

Result<void> StoreLimits::Validate() const {
  if (!std::isfinite(max_writes_per_second) || max_writes_per_second < 0) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "max_writes_per_second: expected at least 0, found {}", max_writes_per_second);
  }
  if (!std::isfinite(max_burst) || max_burst < 1) {
    return MakeError(ErrorCode::kInvalidArgument, "max_burst: expected at least 1, found {}",
                     max_burst);
  }
  return {};
}

StoreLimits StoreLimits::None() {
  constexpr auto kAny = std::numeric_limits<std::size_t>::max();
  return {.max_anchors_per_owner = kAny,
          .max_payload_bytes_per_owner = kAny,
          .max_writes_per_second = 0};
}

Result<void> StoreOptions::Validate() const {
  if (busy_timeout_s < 0 || busy_timeout_s > 3600) {
    return MakeError(ErrorCode::kInvalidArgument, "busy_timeout_s: expected 0 to 3600, found {}",
                     busy_timeout_s);
  }
  if (checkpoint_pages < 100 || checkpoint_pages > 1'000'000) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "checkpoint_pages: expected 100 to 1000000, found {}", checkpoint_pages);
  }
  return limits.Validate();
}

bool IsPostgresLocation(const std::string& location) {
  return location.starts_with("postgresql://") || location.starts_with("postgres://");
}

Result<std::unique_ptr<AnchorStore>> OpenStore(const std::string& location,
                                               const StoreOptions& options) {
  WAYMARK_TRY_ASSIGN(auto database, internal::OpenDatabase(location, options));
  return internal::OpenSqlStore(std::move(database), options);
}

Result<std::unique_ptr<AnchorStore>> OpenSqliteStore(const std::filesystem::path& file,
                                                     const StoreOptions& options) {
  WAYMARK_TRY(options.Validate());
  return internal::OpenSqlStore(internal::MakeSqliteDatabase(file, options), options);
}

Result<std::unique_ptr<AnchorStore>> OpenPostgresStore(const std::string& uri,
                                                       const StoreOptions& options) {
  WAYMARK_TRY(options.Validate());
  return internal::OpenSqlStore(internal::MakePostgresDatabase(uri, options), options);
}

namespace internal {

Result<std::unique_ptr<AnchorDatabase>> OpenDatabase(const std::string& location,
                                                     const StoreOptions& options) {
  WAYMARK_TRY(options.Validate());
  if (IsPostgresLocation(location)) return MakePostgresDatabase(location, options);
  return MakeSqliteDatabase(location, options);
}

}  // namespace internal
}  // namespace waymark::content

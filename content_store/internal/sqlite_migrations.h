// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <span>
#include <string>
#include <string_view>

#include "mapping/base/result.h"

namespace waymark::content::internal {

/// One table or index.
struct SchemaObject {
  std::string_view name;
  std::string_view sql;  ///< as sqlite_master keeps it, byte for byte
};

/// All objects of a version in the order of their names; FORMAT.md explains every column.
/// Shapes: 1 <= version <= kSchemaVersion
std::span<const SchemaObject> SqliteSchema(int version);

/// Brings a store from this version to the next, inside the caller's transaction. Throws what SOCI
/// throws. Errors: Corrupt.
Result<void> MigrateSqlite(soci::session& sql, const std::string& name, int version);

}  // namespace waymark::content::internal

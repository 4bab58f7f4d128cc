// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <filesystem>

#include "content_store/anchor_store.h"
#include "mapping/base/result.h"

namespace waymark::content::internal {

/// Sets the connection's pragmas, creates the schema in an empty database and refuses a foreign,
/// damaged or newer one. Throws what SOCI throws. Errors: Corrupt, Unsupported, Unavailable.
Result<void> PrepareSchema(soci::session& sql, const std::filesystem::path& file, OpenMode mode);

}  // namespace waymark::content::internal

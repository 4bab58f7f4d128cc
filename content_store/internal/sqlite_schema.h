// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <string>

#include "content_store/anchor_store.h"
#include "mapping/base/result.h"

namespace waymark::content::internal {

/// Sets the connection's pragmas, creates the schema in an empty database, brings an older one to
/// the present version if the options allow, and refuses a foreign, damaged or newer one. Throws
/// what SOCI throws. Errors: Corrupt, Unsupported, Unavailable.
Result<void> PrepareSqliteSchema(soci::session& sql, const std::string& name,
                                 const StoreOptions& options);

}  // namespace waymark::content::internal

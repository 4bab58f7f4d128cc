// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <string>

#include "content_store/anchor_store.h"
#include "mapping/base/result.h"

namespace waymark::content::internal {

/// Creates the schema "waymark" where it is absent, brings an older one to the present version if
/// the options allow, and refuses a newer one. Throws what SOCI throws. Errors: NotFound,
/// Unsupported.
Result<void> PreparePostgresSchema(soci::session& sql, const std::string& name,
                                   const StoreOptions& options);

}  // namespace waymark::content::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "content_store/anchor_store.h"
#include "content_store/internal/anchor_tables.h"

namespace waymark::content::internal {

/// The database at a location of OpenStore. Errors: InvalidArgument.
Result<std::unique_ptr<AnchorDatabase>> OpenDatabase(const std::string& location,
                                                     const StoreOptions& options);

}  // namespace waymark::content::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "content_store/anchor_store.h"
#include "content_store/internal/anchor_tables.h"

namespace waymark::content::internal {

/// Connections to one PostgreSQL database.
std::unique_ptr<AnchorDatabase> MakePostgresDatabase(const std::string& uri,
                                                     const StoreOptions& options);

}  // namespace waymark::content::internal

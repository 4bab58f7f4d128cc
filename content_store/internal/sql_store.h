// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "content_store/anchor_store.h"
#include "content_store/internal/anchor_tables.h"

namespace waymark::content::internal {

/// The anchor store over any database. Writes share commits on one connection, reads have a pool.
Result<std::unique_ptr<AnchorStore>> OpenSqlStore(std::unique_ptr<AnchorDatabase> database,
                                                  const StoreOptions& options);

}  // namespace waymark::content::internal

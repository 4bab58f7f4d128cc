// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "content_store/anchor_store.h"
#include "content_store/internal/anchor_tables.h"

namespace waymark::content::internal {

/// Connections to one SQLite file.
std::unique_ptr<AnchorDatabase> MakeSqliteDatabase(const std::filesystem::path& file,
                                                   const StoreOptions& options);

}  // namespace waymark::content::internal

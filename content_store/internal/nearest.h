// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "content_store/internal/anchor_tables.h"

namespace waymark::content::internal {

/// The answer of AnchorStore::FindNear, for a valid centre and radius and a limit above 0. Cells
/// decide which anchors may belong to it, so that only those are read; their places decide which
/// do. Throws what SOCI throws. Errors: Corrupt.
Result<std::vector<AnchorRecord>> FindNearest(AnchorTables& tables, const RoomId& room,
                                              const GeoPoint& centre, double radius_m,
                                              std::size_t limit);

}  // namespace waymark::content::internal

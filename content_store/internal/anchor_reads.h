// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "content_store/internal/anchor_tables.h"

/// What AnchorStore's reading operations answer, on one picture of the database. All throw what
/// SOCI throws. Errors: Corrupt.
namespace waymark::content::internal {

Result<std::optional<AnchorRecord>> FindAnchor(AnchorTables& tables, const AnchorKey& key);
Result<RoomSnapshot> LoadSnapshot(AnchorTables& tables, const RoomId& room);
Result<std::vector<AnchorChange>> FindChanges(AnchorTables& tables,
                                              const std::optional<RoomId>& room,
                                              std::uint64_t after_revision, std::size_t limit);

}  // namespace waymark::content::internal

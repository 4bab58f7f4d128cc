// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "content_store/anchor_query.h"
#include "content_store/internal/anchor_tables.h"

namespace waymark::content::internal {

inline constexpr std::size_t kMaxReplaced = 100'000;  ///< changes between the pages of one query

/// One page of a valid query, exact as of the revision of its first page: anchors that did not
/// change since come from the index, the others from their old states in the log. Throws what SOCI
/// throws. Errors: Corrupt, Conflict, InvalidArgument.
Result<AnchorPage> FindPage(AnchorTables& tables, const AnchorQuery& query);

}  // namespace waymark::content::internal

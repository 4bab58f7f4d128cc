// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "content_store/anchor_query.h"

namespace waymark::content::internal {

/// Whether a record belongs to the answer of a query, page and limit aside.
bool Matches(const AnchorQuery& query, const AnchorRecord& record);

}  // namespace waymark::content::internal

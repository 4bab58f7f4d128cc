// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/fusion/internal/terms.h"

namespace waymark::mapping {

/// A submap between right overlaps and wrong ones may stand where it satisfies none: Huber's middle
/// is a minimum of Cauchy's loss, too. Each free submap that most of its overlaps disagree with
/// goes to where one of them wants it, if all it is in costs less there. In the order of submaps;
/// the spreads must have been estimated.
void TryOverlaps(const FusionTerms& terms, const std::vector<bool>& is_free,
                 const FusionOptions& options, std::vector<Place>& places);

}  // namespace waymark::mapping

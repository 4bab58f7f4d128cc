// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/sfm/incremental.h"
#include "mapping/sfm/internal/model.h"
#include "mapping/sfm/internal/view_graph.h"

namespace waymark::mapping::internal {

/// Pairs worth starting from, best first: many matches at a good angle, not explained by a plane,
/// both images allowed. Indices into the graph's pairs.
std::vector<std::size_t> RankInitialPairs(const ViewGraph& graph,
                                          const std::vector<bool>& is_allowed);

/// Registers both images of the pair in an empty model, triangulates and adjusts. False, with the
/// model empty again: too few points came out.
bool StartFromPair(Model& model, const VerifiedPair& pair, const SfmOptions& options);

}  // namespace waymark::mapping::internal

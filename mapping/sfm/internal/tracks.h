// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/sfm/internal/view_graph.h"
#include "mapping/sfm/reconstruction.h"

namespace waymark::mapping::internal {

/// Chains verified matches into tracks: the features that are one point of the world, at most one
/// per image. A match that would put two features of one image into a track is refused; pairs
/// with more matches go first, as they are seldom wrong.
/// Returns tracks of at least two elements, each sorted by image; deterministic.
std::vector<std::vector<TrackElement>> BuildTracks(std::span<const VerifiedPair> pairs,
                                                   std::span<const std::size_t> feature_counts);

}  // namespace waymark::mapping::internal

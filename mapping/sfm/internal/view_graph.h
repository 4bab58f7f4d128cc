// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/estimation/two_view.h"
#include "mapping/sfm/incremental.h"

namespace waymark::mapping::internal {

/// A pair of images whose matches agree with one relative pose.
struct VerifiedPair {
  ImagePair images;
  std::vector<FeatureMatch> matches;  ///< the inliers
  TwoViewGeometry view;
};

/// Which images see the same things.
struct ViewGraph {
  std::vector<VerifiedPair> pairs;         ///< in input order
  std::vector<std::size_t> most_matches;   ///< per image: raw matches of its richest pair
  std::vector<std::size_t> most_verified;  ///< per image: inliers of its best pair
};

/// Verifies every pair by two-view geometry, on several threads with the same outcome.
ViewGraph VerifyPairs(std::span<const SfmCamera> cameras, std::span<const SfmImage> images,
                      std::span<const PairMatches> matches, const SfmOptions& options);

/// Groups of images that verified pairs connect, only through images that `is_allowed`; largest
/// first, each ascending. Images without a pair form no group.
std::vector<std::vector<std::uint32_t>> ConnectedGroups(const ViewGraph& graph,
                                                        const std::vector<bool>& is_allowed);

}  // namespace waymark::mapping::internal

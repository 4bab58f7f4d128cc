// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/fusion/fusion.h"

namespace waymark::mapping {

/// One image seen from two submaps: indices into their image lists.
struct SharedImage {
  std::uint32_t in_first;
  std::uint32_t in_second;
};

/// All images that two submaps have in common.
struct Overlap {
  std::uint32_t first;  ///< first < second, indices of submaps
  std::uint32_t second;
  std::vector<SharedImage> images;
};

/// Every pair of submaps with shared images, sorted.
/// Errors: InvalidArgument when a submap holds an image twice.
Result<std::vector<Overlap>> FindOverlaps(std::span<const FusionSubmap> submaps);

/// The similarity between two submaps that most of their shared images agree on: rotation by the
/// image whose relative rotation is nearest to all others, scale and translation by medians.
/// nullopt: fewer than two distinct positions.
std::optional<Sim3> EstimateFirstFromSecond(const FusionSubmap& first, const FusionSubmap& second,
                                            const Overlap& overlap);

/// First guesses for all submaps that can be placed: previous release, then GNSS, then through the
/// overlaps with most images. `held` is the submap that fixes the gauge when there is no GNSS.
struct FirstGuess {
  std::vector<std::optional<Sim3>> map_from_submap;
  std::optional<std::uint32_t> held;
};
FirstGuess GuessPlaces(std::span<const FusionSubmap> submaps, std::span<const Overlap> overlaps,
                       bool is_geo_referenced, const FusionOptions& options);

/// `count` indices spread evenly over [0, size); all when there are no more.
std::vector<std::uint32_t> SpreadIndices(std::size_t size, std::size_t count);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/geometry/frames.h"

namespace waymark::mapping {

/// What splitting knows of an image.
struct SplitImage {
  SensorTime time;
  std::optional<Point<Map>> position;  ///< GNSS; only east and north are used
};

/// An image of another experience that is in the map already.
struct ForeignImage {
  std::uint32_t experience;  ///< any number that tells other experiences apart
  std::optional<Point<Map>> position;
};

/// The defaults are the paper's: at most 1,000 images, radius at least 20 m, about 50 m across,
/// neighbours overlap by 20 m.
struct SplitOptions {
  int max_images = 1000;         ///< of one subset, borrowed ones included, >= 4
  double radius_m = 25;          ///< of a subset where images allow it, > 0
  double min_radius_m = 20;      ///< dense places are thinned out rather than cut smaller, > 0
  double overlap_m = 20;         ///< of neighbouring circles, [0, 2 min_radius_m)
  int min_images = 20;           ///< sparse subsets grow until they own as many, >= 1
  int min_shared_images = 6;     ///< circles of sparse places widen until they borrow as many, >= 0
  double max_radius_m = 100;     ///< but no circle is larger than this, >= radius_m
  double neighbour_share = 0.4;  ///< of max_images may be borrowed from neighbouring subsets
  double foreign_share =
      0.2;  ///< of max_images may be borrowed from other experiences; both together <= 0.75
  std::uint64_t seed = 1;

  Result<void> Validate() const;
};

/// The images of one submap. Every image with a position lies in the circle.
struct ImageSubset {
  std::optional<Point<Map>> centre;      ///< absent without GNSS
  double radius_m = 0;                   ///< 0 without GNSS
  std::vector<std::uint32_t> owned;      ///< indices into `images`, ascending
  std::vector<std::uint32_t> neighbour;  ///< owned by another subset, for fusion; ascending
  std::vector<std::uint32_t> foreign;    ///< indices into `foreign`, ascending
};

struct Split {
  std::vector<ImageSubset> subsets;
  std::vector<std::uint32_t> thinned_out;  ///< images in no subset because their place is dense
};

/// Groups the images of one experience into overlapping circles by a greedy line sweep along the
/// longest extent of its positions: the first image not yet owned grows a core; the subset is the
/// core's smallest circle, widened by half the overlap. Each image is owned by one subset or
/// thinned out. Positions that nothing can have reached count as absent; images without one go
/// where those nearest in time are. Fewer than 3 positions: windows of the sequence instead of
/// circles. Deterministic.
/// Errors: InvalidArgument (options, no image).
/// Source: Platinsky et al. 2020, step 1.
Result<Split> SplitExperience(std::span<const SplitImage> images,
                              std::span<const ForeignImage> foreign, const SplitOptions& options);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/base/parallel.h"
#include "mapping/base/result.h"
#include "mapping/geometry/frames.h"

namespace waymark::mapping {

/// What fusion knows of an image in one submap.
struct FusionImage {
  std::uint64_t image;  ///< equal numbers in two submaps are the same image
  Transform<Submap, Camera> submap_from_camera;
  std::optional<Point<Map>> gnss_in_map = std::nullopt;  ///< of the camera centre
  double gnss_sigma_m = 1;
};

/// What fusion knows of a submap.
struct FusionSubmap {
  std::vector<FusionImage> images;
  /// The east-north-up frame at the submap's origin. It says where up is, and is the first guess
  /// of a geo-aligned submap.
  Similarity<Map, Submap> map_from_enu;
  bool is_geo_aligned = true;  ///< false: the submap frame is arbitrary; overlaps must place it
  /// How well the submap's z axis is known to point up; absent: not at all.
  std::optional<double> gravity_sigma_rad = std::nullopt;
  std::optional<Similarity<Map, Submap>> previous = std::nullopt;  ///< in the parent release
};

struct FusionOptions {
  double overlap_sigma_m = 0.05;        ///< of an image's position in two good submaps
  double orientation_sigma_rad = 0.01;  ///< of its orientation
  double gnss_weight =
      0.1;  ///< lambda of cost (2); below 1 because fixes of one drive err together
  double gnss_outlier_sigma = 3;  ///< a fix off by more counts ever less
  double scale_sigma = 0.05;      ///< of a geo-aligned submap's scale
  int max_shared_images = 60;     ///< per pair of submaps, evenly chosen, >= 2
  int max_gnss_images = 100;      ///< per submap, evenly chosen, >= 1
  int min_shared_images = 3;      ///< to place a submap that is not geo-aligned, >= 2
  int max_iterations = 50;        ///< of each of the two rounds
  Parallelism parallelism = {};

  Result<void> Validate() const;
};

/// Where a submap ended up, with its evidence.
struct FusedSubmap {
  /// Absent: the submap is not geo-aligned and shares too few images with those that are placed.
  std::optional<Similarity<Map, Submap>> map_from_submap;
  int shared_images = 0;       ///< images it has in common with others, counted per other submap
  int disagreeing_images = 0;  ///< of these, so far off that they do not count
  double overlap_rms_m = 0;    ///< over the agreeing ones
  int gnss_images = 0;
  double gnss_rms_m = 0;  ///< over all of them
  /// Since the parent release, at the centroid of the submap's cameras; 0, 0, 1 without one.
  double moved_m = 0;
  double turned_rad = 0;
  double scale_ratio = 1;
};

struct Fusion {
  std::vector<FusedSubmap> submaps;  ///< in input order
  int iterations = 0;
  bool converged = true;
  bool is_geo_referenced = false;  ///< false: no GNSS; one submap was held where it was
};

/// Places all submaps by one similarity each: minimises the displacement of shared images and the
/// distance to GNSS, cost (2), made robust, with the orientation of shared images and gravity,
/// which positions alone leave open along a straight street. Two rounds: Huber from the first
/// guess, then Cauchy with the spread found for each pair of submaps. Deterministic for equal
/// input on one thread.
/// Errors: InvalidArgument (options, a submap without images or with an image twice).
/// Source: Platinsky et al. 2020, eq. (2).
Result<Fusion> FuseSubmaps(std::span<const FusionSubmap> submaps, const FusionOptions& options);

}  // namespace waymark::mapping

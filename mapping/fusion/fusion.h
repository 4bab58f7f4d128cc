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
  /// How well the submap's own metre is known, relative to it; absent: FusionOptions::scale_sigma
  /// when it is geo-aligned, not at all when it is not.
  std::optional<double> scale_sigma = std::nullopt;
  std::optional<Similarity<Map, Submap>> previous = std::nullopt;  ///< in the parent release
};

struct FusionOptions {
  double overlap_sigma_m = 0.05;        ///< of an image's position in two good submaps
  double orientation_sigma_rad = 0.01;  ///< of its orientation
  double gnss_weight =
      0.1;  ///< lambda of cost (2); below 1 because fixes of one drive err together
  double gnss_outlier_sigma = 3;  ///< a fix off by more counts ever less
  double scale_sigma = 0.05;      ///< of a geo-aligned submap's scale that tells none of its own
  int max_shared_images = 60;     ///< per pair of submaps, evenly chosen, >= 2
  int max_gnss_images = 100;      ///< per submap, evenly chosen, >= 1
  int min_shared_images = 3;      ///< to place a submap that is not geo-aligned, >= 2
  int max_iterations = 50;        ///< of the second round
  /// UpdateFusion leaves a submap where it was when it would move by less; well below a millimetre.
  double held_motion_m = 2e-4;
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
  bool is_held = false;  ///< UpdateFusion left it where it was, exactly
};

struct Fusion {
  std::vector<FusedSubmap> submaps;  ///< in input order
  int iterations = 0;                ///< steps of all submaps; those of some count for their share
  bool converged = true;
  bool is_geo_referenced = false;  ///< false: no GNSS; one submap was held where it was
};

/// Places all submaps by one similarity each: minimises the displacement of shared images and the
/// distance to GNSS, cost (2), made robust, with the orientation of shared images and gravity,
/// which positions alone leave open along a straight street. Two rounds: Huber from the first
/// guess, then Cauchy with the spread found for each pair of submaps. Equal input gives equal bytes
/// on any number of threads.
/// Errors: InvalidArgument (options, a submap without images or with an image twice, a scale_sigma
/// that is not positive); Unavailable (numbers so extreme that the equations have no solution).
/// Source: Platinsky et al. 2020, eq. (2).
Result<Fusion> FuseSubmaps(std::span<const FusionSubmap> submaps, const FusionOptions& options);

/// The same after a small change: submaps with `previous` stood there in a release of FuseSubmaps
/// or UpdateFusion with equal options; those without are new; others may have gone. What changed is
/// found, not told. Solves around the change, widens until no submap outside would move by
/// `held_motion_m` when all are solved together, and leaves those outside exactly where they were;
/// when half of the map would move, or nothing has a previous place, it is FuseSubmaps.
/// The difference to FuseSubmaps of the same input is a few times `held_motion_m` while both settle
/// on the same overlaps as wrong. Cauchy's loss has more than one minimum, so an overlap on the
/// brink (off by some sigmas, with nothing else to decide) may end on either side.
/// Errors: as above.
Result<Fusion> UpdateFusion(std::span<const FusionSubmap> submaps, const FusionOptions& options);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// What two views see of each other.
enum class TwoViewKind {
  kGeneral,   ///< translation and depth are observable
  kPlanar,    ///< one homography explains nearly all: a plane, or hardly any parallax
  kRotation,  ///< the camera only turned: no translation, no depth
};

struct TwoViewOptions {
  double max_error_px = 4;
  int min_inliers = 15;
  double confidence = 0.9999;
  int max_iterations =
      500;  ///< finds 4 in 10 inliers surely, 3 in 10 mostly; a hopeless pair costs them all
  std::uint64_t seed = 1;

  Result<void> Validate() const;
};

struct TwoViewGeometry {
  TwoViewKind kind = TwoViewKind::kGeneral;
  Rigid3 first_from_second;            ///< translation of unit length; meaningless for kRotation
  std::vector<std::uint32_t> inliers;  ///< indices of the matches, ascending
  double median_angle_rad = 0;         ///< between the rays to the same point
  double homography_share = 0;         ///< of the inliers that one homography explains
};

/// Verifies matches of two calibrated views: five-point essential matrix in a locally optimised
/// robust loop, then the tests for a plane and for pure rotation. nullopt: too few inliers.
/// Shapes: equal lengths. Errors: InvalidArgument if lengths differ.
/// Source: OpenGV's five-point solver (Stewenius, Engels & Nister, ISPRS 2006).
Result<std::optional<TwoViewGeometry>> EstimateTwoView(const CameraModel& first,
                                                       const CameraModel& second,
                                                       std::span<const Eigen::Vector2d> first_px,
                                                       std::span<const Eigen::Vector2d> second_px,
                                                       const TwoViewOptions& options);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "mapping/geometry/camera_model.h"

namespace waymark::localiser::internal {

/// The decimal logarithm of how many poses with so many inliers chance alone would produce.
/// Units:  `chance` is the probability that a wrong match is an inlier of a wrong pose
/// Source: Moisan & Stival, IJCV 2004, eq. (6), for a minimal sample of three; as in Moulon et al.,
///         "Adaptive structure from motion with a contrario model estimation", ACCV 2012
double LogExpectedFalsePoses(std::size_t matches, std::size_t inliers, double chance);

/// The evidence for one pose.
struct PoseEvidence {
  std::size_t matches;
  std::span<const Eigen::Vector2d> inliers_px;
  Eigen::Matrix3d position_covariance;
  double median_distance_m;  ///< from the camera to the inlying landmarks
  double max_error_px;
};

/// Why a pose is not to be trusted, with figures; nullopt when it is. A false pose is worse than
/// none, so each way to be wrong has its own limit: chance, one small patch, poor geometry.
std::optional<std::string> FindReasonToRefuse(const PoseEvidence& evidence,
                                              const CameraModel& camera);

/// The evidence of one pose or of a burst's, counted.
struct CountedEvidence {
  std::size_t matches;
  std::size_t inliers;
  double chance;      ///< that a wrong match is an inlier, see ChanceOfInlier
  std::size_t parts;  ///< of the image, that inliers touch
  Eigen::Matrix3d position_covariance;
  double median_distance_m;
};
std::optional<std::string> FindReasonToRefuse(const CountedEvidence& evidence);

/// Why a pose that may well be right is not to be shown: by its own covariance it may be off by
/// more than a metre or five degrees. Metres count where the map has them.
std::optional<std::string> FindDoubt(const Eigen::Matrix<double, 6, 6>& covariance,
                                     bool is_map_in_metres);

/// Whether the lens that a pose's inliers fit with is the one stated, whose focal length is in
/// doubt by a share. Units: `focal_factor` is on the stated one
std::optional<std::string> FindLensContradiction(std::size_t inliers, double focal_factor,
                                                 double focal_sigma_share);

/// An image has so many parts along each side.
inline constexpr int kImageParts = 8;

/// The probability that a wrong match is an inlier of a wrong pose.
double ChanceOfInlier(double max_error_px, const CameraModel& camera);

}  // namespace waymark::localiser::internal

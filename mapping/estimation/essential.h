// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// A pixel pair in normalised coordinates, with what one pixel is worth at each end.
struct NormalizedMatch {
  Eigen::Vector2d first;
  Eigen::Vector2d second;
  double first_per_px;
  double second_per_px;
};

/// Normalises matched pixels of two cameras.
std::vector<NormalizedMatch> NormalizeMatches(const CameraModel& first, const CameraModel& second,
                                              std::span<const Eigen::Vector2d> first_px,
                                              std::span<const Eigen::Vector2d> second_px);

/// Squared Sampson error in pixels of x1^T E x2 = 0.
double SquaredSampsonErrorPx(const Eigen::Matrix3d& essential, const NormalizedMatch& match);

/// E = [t]x R of first_from_second.
Eigen::Matrix3d EssentialFromPose(const Rigid3& first_from_second);

/// The one of the four decompositions that puts most of the chosen matches in front of both
/// cameras; translation of unit length. nullopt when E is not of rank two.
std::optional<Rigid3> PoseFromEssential(const Eigen::Matrix3d& essential,
                                        std::span<const NormalizedMatch> matches,
                                        std::span<const std::uint32_t> chosen);

/// Depths along both rays (in units of the normalised coordinates' z) of the point nearest to
/// both; nullopt for parallel rays.
std::optional<Eigen::Vector2d> TriangulatedDepths(const Rigid3& first_from_second,
                                                  const NormalizedMatch& match);

/// Angle between the two rays to the same point.
double RayAngle(const Rigid3& first_from_second, const NormalizedMatch& match);

/// Minimises the Huber Sampson error over the chosen matches; translation stays of unit length.
Rigid3 RefineRelativePose(const Rigid3& first_from_second, std::span<const NormalizedMatch> matches,
                          std::span<const std::uint32_t> chosen, double huber_px);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/candidate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace waymark::localiser::internal {
namespace {

// Submaps that overlap see the same image within decimetres; copies of a place are far apart.
constexpr double kSamePlaceM = 5;
constexpr Angle kSameDirection = Angle::Degrees(15);
constexpr double kComparableShare = 0.6;  // of the inliers

Eigen::Matrix<double, 6, 6> CarryCovariance(const Sim3& map_from_submap,
                                            const Eigen::Matrix<double, 6, 6>& in_submap) {
  const Eigen::Matrix3d rotation = map_from_submap.rotation().toRotationMatrix();
  Eigen::Matrix<double, 6, 6> jacobian = Eigen::Matrix<double, 6, 6>::Zero();
  jacobian.topLeftCorner<3, 3>() = map_from_submap.scale() * rotation;
  jacobian.bottomRightCorner<3, 3>() = rotation;
  return jacobian * in_submap * jacobian.transpose();
}

std::optional<std::string> FindContradiction(const LocalisedPose& pose,
                                             const LocalisationRequest& request,
                                             const LocaliserOptions& options) {
  if (request.up_in_camera) {
    const Eigen::Vector3d up_in_map = pose.map_from_camera.rotation() * *request.up_in_camera;
    const Angle error = Angle::Radians(std::atan2(up_in_map.head<2>().norm(), up_in_map.z()));
    if (error > options.max_gravity_error) {
      return fmt::format("gravity contradicts the pose of {} inliers by {:.0f} degrees, at most {}",
                         pose.inliers, error.degrees(), options.max_gravity_error.degrees());
    }
  }
  if (request.prior) {
    const double distance_m =
        (pose.map_from_camera.translation() - request.prior->position.coordinates())
            .head<2>()
            .norm();
    if (distance_m > 2 * request.prior->radius_m) {
      return fmt::format("the pose of {} inliers is {:.0f} m from a prior of {:.0f} m",
                         pose.inliers, distance_m, request.prior->radius_m);
    }
  }
  return std::nullopt;
}

}  // namespace

Candidate CarryToMap(const mapping::ReleasedSubmap& submap, SubmapAnswer answer,
                     const LocalisationRequest& request, const LocaliserOptions& options) {
  Candidate candidate{.submap = &submap,
                      .matches = answer.matches,
                      .pose = std::nullopt,
                      .refusal = std::move(answer.refusal),
                      .ambiguity = std::move(answer.ambiguity)};
  if (!answer.submap_from_camera) return candidate;
  const mapping::AbsolutePose& pose = *answer.submap_from_camera;
  const Transform<Submap, Camera> submap_from_camera(pose.world_from_camera);
  LocalisedPose localised{
      .map_from_camera = CarryPose(submap.map_from_submap, submap_from_camera),
      .covariance = CarryCovariance(submap.map_from_submap.sim(), pose.covariance),
      .submap = submap.id,
      .submap_from_camera = submap_from_camera,
      .inliers = static_cast<int>(pose.inliers.size()),
      .rms_px = pose.rms_px,
  };
  if (auto contradiction = FindContradiction(localised, request, options)) {
    candidate.refusal = *std::move(contradiction);
  } else {
    candidate.pose = std::move(localised);
  }
  return candidate;
}

bool IsMoreConvincing(const Candidate& a, const Candidate& b) {
  const int a_inliers = a.pose ? a.pose->inliers : 0;
  const int b_inliers = b.pose ? b.pose->inliers : 0;
  if (a_inliers != b_inliers) return a_inliers > b_inliers;
  return a.matches > b.matches;
}

std::optional<std::string> FindAmbiguity(std::span<const Candidate> candidates) {
  if (!candidates.front().ambiguity.empty()) return candidates.front().ambiguity;
  const LocalisedPose& best = *candidates.front().pose;
  for (const Candidate& other : candidates.subspan(1)) {
    if (!other.pose || other.pose->inliers < kComparableShare * best.inliers) break;
    const double distance_m =
        (other.pose->map_from_camera.translation() - best.map_from_camera.translation()).norm();
    const Angle turn =
        AngleBetween(other.pose->map_from_camera.rotation(), best.map_from_camera.rotation());
    if (distance_m <= kSamePlaceM && turn <= kSameDirection) continue;
    return fmt::format("two places look alike: {} inliers in submap {}, {} in {}, {:.1f} m apart",
                       best.inliers, best.submap.text(), other.pose->inliers,
                       other.pose->submap.text(), distance_m);
  }
  return std::nullopt;
}

}  // namespace waymark::localiser::internal

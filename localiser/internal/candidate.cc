// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/candidate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "localiser/internal/gravity.h"
#include "localiser/internal/mapped_lens.h"

namespace waymark::localiser::internal {
namespace {

Eigen::Matrix<double, 6, 6> CarryCovariance(const Sim3& map_from_submap,
                                            const Eigen::Matrix<double, 6, 6>& in_submap) {
  const Eigen::Matrix3d rotation = map_from_submap.rotation().toRotationMatrix();
  Eigen::Matrix<double, 6, 6> jacobian = Eigen::Matrix<double, 6, 6>::Zero();
  jacobian.topLeftCorner<3, 3>() = map_from_submap.scale() * rotation;
  jacobian.bottomRightCorner<3, 3>() = rotation;
  return jacobian * in_submap * jacobian.transpose();
}

// Phone and map are each as good as half of what may contradict them, which is twice their sigma.
Angle GravitySigma(const LocaliserOptions& options) {
  return std::numbers::sqrt2 / 4 * options.max_gravity_error;
}

void HeedGravity(const Eigen::Vector3d& up_in_camera, const LocaliserOptions& options,
                 const Similarity<Map, Submap>& map_from_submap, LocalisedPose& pose) {
  const UncertainPose heeded = WithGravity({pose.map_from_camera.rigid(), pose.covariance},
                                           up_in_camera.normalized(), GravitySigma(options));
  pose.map_from_camera = Transform<Map, Camera>(heeded.map_from_camera);
  pose.covariance = heeded.covariance;
  pose.submap_from_camera = CarryPose(map_from_submap.Inverse(), pose.map_from_camera);
}

}  // namespace

std::optional<std::string> FindContradiction(const Transform<Map, Camera>& map_from_camera,
                                             int inliers, const LocalisationRequest& request,
                                             const LocaliserOptions& options) {
  if (request.up_in_camera) {
    const Eigen::Vector3d up_in_map = map_from_camera.rotation() * *request.up_in_camera;
    const Angle error = Angle::Radians(std::atan2(up_in_map.head<2>().norm(), up_in_map.z()));
    if (error > options.max_gravity_error) {
      return fmt::format("gravity contradicts the pose of {} inliers by {:.0f} degrees, at most {}",
                         inliers, error.degrees(), options.max_gravity_error.degrees());
    }
  }
  if (request.prior) {
    const double distance_m =
        (map_from_camera.translation() - request.prior->position.coordinates()).head<2>().norm();
    if (distance_m > request.prior->radius_m) {
      return fmt::format("the pose of {} inliers is {:.0f} m from a prior of {:.0f} m", inliers,
                         distance_m, request.prior->radius_m);
    }
  }
  return std::nullopt;
}

ImageSenses SensesIn(const OpenSubmap& submap, const LocalisationRequest& request) {
  ImageSenses senses{MappedLens(request.camera, submap.view().cameras()), std::nullopt};
  if (request.up_in_camera) {
    const Eigen::Quaterniond& map_from_submap = submap.released().map_from_submap.sim().rotation();
    senses.up = mapping::SharedUp{request.up_in_camera->normalized(),
                                  map_from_submap.conjugate() * Eigen::Vector3d::UnitZ()};
  }
  return senses;
}

Candidate CarryToMap(const OpenSubmap& submap, SubmapAnswer answer,
                     const LocalisationRequest& request, const LocaliserOptions& options) {
  Candidate candidate{
      .submap = &submap, .answer = std::move(answer), .pose = std::nullopt, .refusal = {}};
  candidate.refusal = candidate.answer.refusal;
  if (!candidate.answer.submap_from_camera) return candidate;
  const mapping::ReleasedSubmap& released = submap.released();
  const mapping::AbsolutePose& pose = *candidate.answer.submap_from_camera;
  const Transform<Submap, Camera> submap_from_camera(pose.world_from_camera);
  LocalisedPose localised{
      .map_from_camera = CarryPose(released.map_from_submap, submap_from_camera),
      .covariance = CarryCovariance(released.map_from_submap.sim(), pose.covariance),
      .submap = released.id,
      .submap_from_camera = submap_from_camera,
      .inliers = static_cast<int>(pose.inliers.size()),
      .rms_px = pose.rms_px,
  };
  if (auto contradiction =
          FindContradiction(localised.map_from_camera, localised.inliers, request, options)) {
    candidate.refusal = *std::move(contradiction);
  } else {
    if (request.up_in_camera) {
      HeedGravity(*request.up_in_camera, options, released.map_from_submap, localised);
    }
    candidate.pose = std::move(localised);
  }
  return candidate;
}

bool IsMoreConvincing(const Candidate& a, const Candidate& b) {
  const int a_inliers = a.pose ? a.pose->inliers : 0;
  const int b_inliers = b.pose ? b.pose->inliers : 0;
  if (a_inliers != b_inliers) return a_inliers > b_inliers;
  return a.answer.matches.size() > b.answer.matches.size();
}

void TryWithoutGravity(std::span<Candidate> candidates, const LocalisationRequest& request,
                       const LocaliserOptions& options) {
  constexpr std::size_t kTries = 2;
  if (!request.up_in_camera) return;
  for (Candidate& candidate : candidates.first(std::min(kTries, candidates.size()))) {
    if (candidate.answer.submap_from_camera) continue;  // refused for another reason
    const OpenSubmap& submap = *candidate.submap;
    SubmapAnswer answer = std::move(candidate.answer);
    submap.localiser().EstimatePose({SensesIn(submap, request).camera, std::nullopt}, answer);
    candidate = CarryToMap(submap, std::move(answer), request, options);
  }
  std::stable_sort(candidates.begin(), candidates.end(), IsMoreConvincing);
}

}  // namespace waymark::localiser::internal

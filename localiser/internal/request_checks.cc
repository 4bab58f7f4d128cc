// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/request_checks.h"

#include <fmt/format.h>

#include <cmath>

namespace waymark::localiser::internal {
namespace {

constexpr double kMaxDistanceM = 1000;  // between two images of a burst

bool IsPose(const Rigid3& vo_from_camera) {
  return vo_from_camera.translation().allFinite() &&
         vo_from_camera.rotation().coeffs().allFinite() &&
         std::abs(vo_from_camera.rotation().norm() - 1) < 1e-6;
}

}  // namespace

std::optional<std::string> FindContradiction(const LocalisationRequest& request) {
  if (const auto* image = std::get_if<mapping::GrayImage>(&request.image)) {
    if (image->width_px != request.camera.width_px() ||
        image->height_px != request.camera.height_px()) {
      return fmt::format("the image has {}x{} pixels, its camera {}x{}", image->width_px,
                         image->height_px, request.camera.width_px(), request.camera.height_px());
    }
  } else {
    const auto& features = std::get<mapping::ImageFeatures>(request.image);
    if (features.keypoints.size() != features.descriptors.size()) {
      return fmt::format("{} keypoints, but {} descriptors", features.keypoints.size(),
                         features.descriptors.size());
    }
    for (const mapping::Keypoint& keypoint : features.keypoints) {
      if (!request.camera.Contains({keypoint.x_px, keypoint.y_px})) {
        return fmt::format("a keypoint at ({}, {}) is outside the image", keypoint.x_px,
                           keypoint.y_px);
      }
    }
  }
  if (request.prior && !(request.prior->position.coordinates().allFinite() &&
                         std::isfinite(request.prior->radius_m) && request.prior->radius_m > 0)) {
    return "the prior is not finite, or its radius is not above 0";
  }
  if (request.up_in_camera && !(std::abs(request.up_in_camera->norm() - 1) < 0.01)) {
    return fmt::format("gravity has length {}, expected 1", request.up_in_camera->norm());
  }
  return std::nullopt;
}

std::optional<std::string> FindContradiction(const BurstRequest& burst, Angle max_gravity_error) {
  const std::size_t count = burst.images.size();
  if (count < BurstRequest::kMinImages || count > BurstRequest::kMaxImages) {
    return fmt::format("a burst of {} images, expected {} to {}", count, BurstRequest::kMinImages,
                       BurstRequest::kMaxImages);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [request, vo_from_camera] = burst.images[i];
    if (const auto contradiction = FindContradiction(request)) {
      return fmt::format("image {} of {}: {}", i + 1, count, *contradiction);
    }
    if (!IsPose(vo_from_camera.rigid())) {
      return fmt::format("image {} of {}: its pose in odometry is not finite, or no rotation",
                         i + 1, count);
    }
    const double distance_m =
        (vo_from_camera.translation() - burst.images.back().vo_from_camera.translation()).norm();
    if (!(distance_m <= kMaxDistanceM)) {
      return fmt::format("image {} of {} was taken {:.0f} m from the last, at most {:.0f}", i + 1,
                         count, distance_m, kMaxDistanceM);
    }
    if (!request.up_in_camera) continue;
    const Eigen::Vector3d up = request.up_in_camera->normalized();
    const Eigen::Vector3d odometry_up = UpInCamera(vo_from_camera);
    const Angle error =
        Angle::Radians(std::atan2(up.cross(odometry_up).norm(), up.dot(odometry_up)));
    if (error > 2.0 * max_gravity_error) {
      return fmt::format("image {} of {}: gravity is {:.0f} degrees from odometry's z", i + 1,
                         count, error.degrees());
    }
  }
  return std::nullopt;
}

Eigen::Vector3d UpInCamera(const Transform<Vo, Camera>& vo_from_camera) {
  return vo_from_camera.rotation().conjugate() * Eigen::Vector3d::UnitZ();
}

}  // namespace waymark::localiser::internal

// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/internal/submap_rules.h"

#include <cmath>

#include "mapping/experience/names.h"

namespace waymark::mapping::internal {
namespace {

Result<void> CheckSummary(const SubmapModel& model) {
  WAYMARK_TRY(model.origin.Validate());
  const VerificationEvidence& e = model.evidence;
  if (!std::isfinite(e.max_gyroscope_error_rad) || !std::isfinite(e.max_gravity_error_rad) ||
      !std::isfinite(e.max_speed_mps) || !std::isfinite(e.mean_reprojection_px) ||
      !IsPrintableText(e.verdict)) {
    return Error{ErrorCode::kInvalidArgument,
                 "evidence: expected finite figures and a printable verdict"};
  }
  if (model.scale_sigma && !(*model.scale_sigma > 0 && std::isfinite(*model.scale_sigma))) {
    return MakeError(ErrorCode::kInvalidArgument, "expected a scale sigma above 0, found {}",
                     *model.scale_sigma);
  }
  return {};
}

Result<void> CheckImage(const SubmapImage& image, std::size_t camera_count) {
  if (!IsExperienceIdText(image.experience.text()) || !IsImageName(image.name)) {
    return Error{ErrorCode::kInvalidArgument, "expected a usable experience id and image name"};
  }
  if (image.camera >= camera_count) {
    return MakeError(ErrorCode::kInvalidArgument, "expected a camera below {}, found {}",
                     camera_count, image.camera);
  }
  if (!image.submap_from_camera.translation().allFinite() ||
      !image.submap_from_camera.rotation().coeffs().allFinite()) {
    return Error{ErrorCode::kInvalidArgument, "expected a finite pose"};
  }
  if (image.gnss) WAYMARK_TRY(image.gnss->Validate());
  if (!(image.gnss_sigma_m > 0) || !std::isfinite(image.gnss_sigma_m)) {
    return MakeError(ErrorCode::kInvalidArgument, "expected a GNSS sigma above 0, found {}",
                     image.gnss_sigma_m);
  }
  return {};
}

}  // namespace

Result<void> CheckSmallParts(const SubmapModel& model) {
  WAYMARK_TRY(CheckSummary(model));
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    if (auto result = CheckImage(model.images[i], model.cameras.size()); !result) {
      return MakeError(result.error().code, "image {}: {}", i, result.error().message);
    }
  }
  return {};
}

Result<void> CheckObservation(std::size_t i, const ObservedIndices& previous,
                              const ObservedIndices& indices, float x_px, float y_px,
                              std::size_t landmark_count, std::size_t image_count) {
  if (indices.landmark >= landmark_count || indices.image >= image_count) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "observation {}: expected a landmark below {} and an image below {}, found {} "
                     "and {}",
                     i, landmark_count, image_count, indices.landmark, indices.image);
  }
  if (i > 0 && indices < previous) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "observation {}: expected the order of (landmark, image), found ({}, {}) "
                     "after ({}, {})",
                     i, indices.landmark, indices.image, previous.landmark, previous.image);
  }
  if (!std::isfinite(x_px) || !std::isfinite(y_px)) {
    return MakeError(ErrorCode::kInvalidArgument, "observation {}: expected a finite pixel", i);
  }
  return {};
}

Result<void> CheckModel(const SubmapModel& model) {
  WAYMARK_TRY(CheckSmallParts(model));
  for (std::size_t i = 0; i < model.landmarks.size(); ++i) {
    if (model.landmarks[i].coordinates().allFinite()) continue;
    return MakeError(ErrorCode::kInvalidArgument, "landmark {}: expected a finite position", i);
  }
  ObservedIndices previous{};
  for (std::size_t i = 0; i < model.observations.size(); ++i) {
    const LandmarkObservation& o = model.observations[i];
    const ObservedIndices indices{o.landmark, o.image};
    WAYMARK_TRY(CheckObservation(i, previous, indices, o.x_px, o.y_px, model.landmarks.size(),
                                 model.images.size()));
    previous = indices;
  }
  return {};
}

}  // namespace waymark::mapping::internal

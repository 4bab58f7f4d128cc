// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/assemble.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace waymark::mapping {
namespace {

Result<void> CheckInput(const Reconstruction& reconstruction,
                        std::span<const AssemblyImage> images) {
  if (images.size() != reconstruction.images.size()) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "assembling a submap: {} images for a reconstruction of {}", images.size(),
                     reconstruction.images.size());
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (reconstruction.images[i].camera >= reconstruction.cameras.size()) {
      return MakeError(ErrorCode::kInvalidArgument, "assembling a submap: {} names camera {} of {}",
                       images[i].name, reconstruction.images[i].camera,
                       reconstruction.cameras.size());
    }
  }
  for (const ReconstructedPoint& point : reconstruction.points) {
    for (const TrackElement& element : point.track) {
      if (element.image >= images.size() ||
          !reconstruction.images[element.image].submap_from_camera ||
          element.feature >= images[element.image].features->keypoints.size()) {
        return MakeError(ErrorCode::kInvalidArgument,
                         "assembling a submap: a track names feature {} of image {}",
                         element.feature, element.image);
      }
    }
  }
  return {};
}

/// Registered images and the cameras they use. Returns the submap index of each input image.
std::vector<std::optional<std::uint32_t>> AddImages(const Reconstruction& reconstruction,
                                                    std::span<const AssemblyImage> images,
                                                    SubmapModel& model) {
  std::vector<std::optional<std::uint32_t>> camera_index(reconstruction.cameras.size());
  std::vector<std::optional<std::uint32_t>> image_index(images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    const ReconstructedImage& registered = reconstruction.images[i];
    if (!registered.submap_from_camera) continue;
    auto& camera = camera_index[registered.camera];
    if (!camera) {
      camera = static_cast<std::uint32_t>(model.cameras.size());
      model.cameras.push_back(reconstruction.cameras[registered.camera]);
    }
    image_index[i] = static_cast<std::uint32_t>(model.images.size());
    model.images.push_back({.experience = images[i].experience,
                            .name = images[i].name,
                            .camera = *camera,
                            .submap_from_camera = *registered.submap_from_camera,
                            .gnss = model.evidence.gnss_is_trusted ? images[i].gnss : std::nullopt,
                            .gnss_sigma_m = images[i].gnss_sigma_m,
                            .is_borrowed = images[i].is_borrowed});
  }
  return image_index;
}

/// The shortest track that is kept.
std::size_t ChooseMinTrack(const Reconstruction& reconstruction, const AssemblyOptions& options) {
  const std::size_t wanted = static_cast<std::size_t>(options.min_track);
  const auto strong =
      std::count_if(reconstruction.points.begin(), reconstruction.points.end(),
                    [&](const ReconstructedPoint& point) { return point.track.size() >= wanted; });
  return strong >= options.enough_landmarks ? wanted : 2;
}

void AddLandmark(const ReconstructedPoint& point, std::span<const AssemblyImage> images,
                 std::span<const std::optional<std::uint32_t>> image_index, std::size_t limit,
                 SubmapModel& model) {
  const auto landmark = static_cast<std::uint32_t>(model.landmarks.size());
  model.landmarks.push_back(point.position);
  const std::size_t kept = std::min(limit, point.track.size());
  for (std::size_t k = 0; k < kept; ++k) {
    // Evenly over the track, both ends included: the widest change of view.
    const std::size_t chosen = kept == 1 ? 0 : k * (point.track.size() - 1) / (kept - 1);
    const TrackElement& element = point.track[chosen];
    const ImageFeatures& features = *images[element.image].features;
    const Keypoint& keypoint = features.keypoints[element.feature];
    model.observations.push_back({.landmark = landmark,
                                  .image = *image_index[element.image],
                                  .x_px = keypoint.x_px,
                                  .y_px = keypoint.y_px,
                                  .descriptor = features.descriptors[element.feature]});
  }
}

}  // namespace

Result<void> AssemblyOptions::Validate() const {
  if (min_track < 2 || enough_landmarks < 0 || max_observations < 1) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "assembly options: expected min_track >= 2, enough_landmarks >= 0, "
                     "max_observations >= 1; found {}, {}, {}",
                     min_track, enough_landmarks, max_observations);
  }
  return {};
}

Result<SubmapModel> AssembleSubmap(const Reconstruction& reconstruction,
                                   std::span<const AssemblyImage> images, const GeoPoint& origin,
                                   const VerificationEvidence& evidence,
                                   const AssemblyOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY(CheckInput(reconstruction, images));
  SubmapModel model;
  model.origin = origin;
  model.is_geo_aligned = reconstruction.is_geo_aligned;
  model.scale_sigma = reconstruction.scale_sigma;
  model.evidence = evidence;
  const auto image_index = AddImages(reconstruction, images, model);
  const std::size_t min_track = ChooseMinTrack(reconstruction, options);
  for (const ReconstructedPoint& point : reconstruction.points) {
    if (point.track.size() < min_track) continue;
    AddLandmark(point, images, image_index, static_cast<std::size_t>(options.max_observations),
                model);
  }
  return model;
}

}  // namespace waymark::mapping

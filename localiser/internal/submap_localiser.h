// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "localiser/internal/landmark_search.h"
#include "localiser/localiser.h"
#include "mapping/estimation/absolute_pose.h"

namespace waymark::localiser::internal {

/// What one submap makes of one image.
struct SubmapAnswer {
  std::size_t matches = 0;
  std::optional<mapping::AbsolutePose> submap_from_camera;  ///< absent: see refusal
  std::string refusal;
  std::string ambiguity;  ///< why the pose is not the only one here; empty when it is
  double search_ms = 0;
  double pose_ms = 0;
};

/// Finds images in one submap. Borrows the submap's arrays. Immutable, thread-safe.
class SubmapLocaliser {
 public:
  /// Shapes: descriptors[i] shows landmark observed_landmarks[i], which are valid indices.
  SubmapLocaliser(std::span<const Eigen::Vector3d> landmarks_in_submap,
                  std::span<const mapping::Descriptor> descriptors,
                  std::span<const std::uint32_t> observed_landmarks,
                  const CoarseQuantiser& quantiser, const LocaliserOptions& options);

  /// The cells are those of the features, ranked by the same quantiser.
  SubmapAnswer Localise(const mapping::ImageFeatures& features, const RankedCells& cells,
                        const CameraModel& camera) const;

 private:
  SubmapAnswer EstimatePose(const mapping::ImageFeatures& features, const CameraModel& camera,
                            std::span<const LandmarkMatch> matches) const;

  LocaliserOptions options_;
  std::span<const Eigen::Vector3d> landmarks_in_submap_;
  LandmarkSearch search_;
};

}  // namespace waymark::localiser::internal

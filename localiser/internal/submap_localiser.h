// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "localiser/internal/image_matches.h"
#include "localiser/internal/kd_tree_search.h"
#include "localiser/internal/landmark_search.h"
#include "localiser/localiser.h"
#include "mapping/estimation/absolute_pose.h"

namespace waymark::localiser::internal {

/// What one submap makes of one image.
struct SubmapAnswer {
  ImageMatches matches;
  std::vector<Resemblance> resemblances;  ///< of features to landmarks, indices of both
  std::optional<mapping::AbsolutePose> submap_from_camera;  ///< absent: see refusal
  double median_distance_m = 0;                             ///< to what the pose sees
  std::string refusal;
  double search_ms = 0;
  double pose_ms = 0;
};

/// Finds images in one submap. Borrows the landmarks. Immutable, thread-safe.
class SubmapLocaliser {
 public:
  /// Shapes: descriptors[i] shows landmark observed_landmarks[i], which are valid indices; those of
  ///         one landmark lie together.
  SubmapLocaliser(std::span<const Eigen::Vector3d> landmarks_in_submap,
                  std::span<const mapping::Descriptor> descriptors,
                  std::span<const std::uint32_t> observed_landmarks,
                  const CoarseQuantiser& quantiser, const LocaliserOptions& options);

  std::size_t bytes() const;  ///< of its own, not of what it borrows

  /// The cells are those of the features, ranked by the same quantiser.
  SubmapAnswer Localise(const mapping::ImageFeatures& features, const RankedCells& cells,
                        const ImageSenses& senses) const;

  /// The same without a pose.
  SubmapAnswer FindMatches(const mapping::ImageFeatures& features, const RankedCells& cells) const;

  /// Looks for the pose once more, among the same matches, with other senses.
  void EstimatePose(const ImageSenses& senses, SubmapAnswer& answer) const;

  /// Why the pose of an answer is not the only one in this submap; empty when it is.
  std::string FindAmbiguity(const ImageSenses& senses, const SubmapAnswer& answer) const;

 private:
  ImageMatches Match(const mapping::ImageFeatures& features,
                     std::vector<LandmarkMatch> found) const;
  std::optional<std::string> Judge(const CameraModel& camera, const mapping::AbsolutePose& pose,
                                   const SubmapAnswer& answer) const;

  LocaliserOptions options_;
  std::span<const Eigen::Vector3d> landmarks_in_submap_;
  std::variant<LandmarkSearch, KdTreeSearch> search_;
};

}  // namespace waymark::localiser::internal

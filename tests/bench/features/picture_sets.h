// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/features/features.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// Pictures of one place and which of them are compared.
struct PictureSet {
  std::string name;
  std::vector<GrayImage> images;
  std::optional<CameraModel> camera = {};      ///< absent: no truth
  std::vector<Rigid3> world_from_camera = {};  ///< with a camera: one for each image
  std::vector<std::pair<std::size_t, std::size_t>> pairs = {};
};

/// The sets in a data folder: kitti_clip_1, kitti_clip_2, pavilion_midday, fountain, lund. Of
/// long sets every `stride`-th pair is kept. Errors: those of files; NotFound for other names.
Result<PictureSet> LoadPictureSet(const std::filesystem::path& data, const std::string& name,
                                  std::size_t stride);

/// The JPEG and PNG files of a folder, in order of their names; no truth and no pairs.
Result<PictureSet> LoadFolder(const std::filesystem::path& folder, std::size_t limit);

/// How well the features of two pictures fit each other.
struct PairQuality {
  std::size_t correct = 0;  ///< matches within 2 px of their epipolar lines in both pictures
  std::vector<double> errors_px = {};  ///< of those: the mean of the two distances
};

/// With truth the epipolar lines are those of the true poses; without, those of a robust
/// fundamental matrix.
PairQuality JudgePair(const PictureSet& set, std::pair<std::size_t, std::size_t> pair,
                      const ImageFeatures& first, const ImageFeatures& second);

}  // namespace waymark::mapping

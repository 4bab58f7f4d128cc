// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/features/features.h"
#include "mapping/features/internal/scale_space.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal {

/// A keypoint without a descriptor.
struct OrientedExtremum {
  std::uint32_t extremum;  ///< index into ScaleSpace::extrema
  float angle_rad;
};

/// The strongest `max_features`, strongest first, ties by place; each extremum once for every
/// orientation it has. Only the extrema that are kept, or nearly so, are given orientations.
std::vector<OrientedExtremum> SelectStrongest(const ScaleSpace& space, int max_features,
                                              const SiftKernels& kernels);

/// Keypoints, in pixels of the image that the scale space was made from, and their descriptors.
ImageFeatures DescribeAll(const ScaleSpace& space, const std::vector<OrientedExtremum>& selected,
                          const SiftKernels& kernels);

/// Errors: Unavailable when memory is short.
Result<ImageFeatures> ExtractSift(const ImageView& image, const ScaleSpaceOptions& options,
                                  int max_features, const SiftKernels& kernels);

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/features/internal/doubled_image.h"
#include "mapping/features/internal/extrema.h"
#include "mapping/features/internal/kept_buffer.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal {

struct ScaleSpaceOptions {
  double smoothing_px = 0;  ///< of the image before anything else
  ExtremaOptions extrema;
};

/// The layers 1 to kLayers of each octave, where keypoints get orientation and descriptor from,
/// and the extrema. Octave 0 is the doubled image; its pixel i lies at (i + 0.5) / 2 of ours.
struct ScaleSpace {
  KeptBuffer memory;
  std::vector<std::array<Plane, kLayers>> octaves;
  std::vector<Extremum> extrema;  ///< some of them several times; in no particular order
};

/// Errors: Unavailable when memory is short.
Result<ScaleSpace> BuildScaleSpace(const ImageView& image, const ScaleSpaceOptions& options,
                                   const SiftKernels& kernels);

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/lens.h"

#include <algorithm>

#include "mapping/geometry/lens_kind.h"

namespace waymark::mapping::internal {
namespace {

CameraModel WithDistortion(const CameraModel& pinhole) {
  const CameraKind kind = WithRadialDistortion(pinhole.kind());
  std::vector<double> parameters(ParameterCount(kind), 0.0);
  std::ranges::copy(pinhole.parameters(), parameters.begin());
  const auto lens = CameraModel::Create(kind, pinhole.width_px(), pinhole.height_px(), parameters);
  CHECK(lens);  // what is valid stays so with zeros
  return *lens;
}

}  // namespace

std::vector<SfmCamera> AllowDistortion(std::vector<SfmCamera> cameras,
                                       std::span<const SfmImage> images,
                                       const SfmOptions& options) {
  std::vector<std::size_t> image_counts(cameras.size(), 0);
  for (const SfmImage& image : images) ++image_counts[image.camera];
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    SfmCamera& camera = cameras[k];
    const CameraKind kind = camera.model.kind();
    const bool is_pinhole = WithRadialDistortion(kind) != kind;
    if (!is_pinhole || !camera.refine || !options.refine_intrinsics) continue;
    if (image_counts[k] >= kMinImagesToRefineLens) camera.model = WithDistortion(camera.model);
  }
  return cameras;
}

}  // namespace waymark::mapping::internal

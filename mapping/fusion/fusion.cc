// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/fusion.h"

#include <utility>

#include "mapping/fusion/internal/fusing.h"

namespace waymark::mapping {

Result<void> FusionOptions::Validate() const {
  if (!(overlap_sigma_m > 0 && orientation_sigma_rad > 0 && gnss_weight > 0 &&
        gnss_outlier_sigma > 0 && scale_sigma > 0 && held_motion_m > 0)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "fusion options: every sigma, weight and length must be positive");
  }
  if (max_shared_images < 2 || max_gnss_images < 1 || min_shared_images < 2 || max_iterations < 1) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "fusion options: expected max_shared_images >= 2, max_gnss_images >= 1, "
                     "min_shared_images >= 2, max_iterations >= 1; found {}, {}, {}, {}",
                     max_shared_images, max_gnss_images, min_shared_images, max_iterations);
  }
  return {};
}

Result<Fusion> FuseSubmaps(std::span<const FusionSubmap> submaps, const FusionOptions& options) {
  WAYMARK_TRY(options.Validate());
  if (submaps.empty()) return Fusion{};
  WAYMARK_TRY_ASSIGN(Fusing fusing, BeginFusing(submaps, options));
  WAYMARK_TRY(SolveAll(options, fusing));
  return FinishFusing(options, std::move(fusing));
}

}  // namespace waymark::mapping

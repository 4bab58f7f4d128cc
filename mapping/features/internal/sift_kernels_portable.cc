// SPDX-License-Identifier: Apache-2.0
// No Eigen here: code for wider registers must not share its types (alignment differs).
#include "mapping/features/internal/sift_kernels.h"

#include "mapping/features/internal/blur_lanes.h"
#include "mapping/features/internal/descriptor_lanes.h"
#include "mapping/features/internal/extrema_lanes.h"
#include "mapping/features/internal/orientation_lanes.h"

namespace waymark::mapping::internal {

SiftKernels SiftKernelsPortable() {
  using namespace WAYMARK_LANES;  // NOLINT: the one set of this file
  return {"portable", DoubleRow,   FilterColumns,   BlurRows,
          Subtract,   FindExtrema, AddOrientations, Describe};
}

}  // namespace waymark::mapping::internal

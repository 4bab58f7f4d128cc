// SPDX-License-Identifier: Apache-2.0
// No Eigen here: code for wider registers must not share its types (alignment differs).
#include "mapping/features/internal/sift_kernels.h"

#if defined(__AVX512VL__)

#include "mapping/features/internal/blur_lanes.h"
#include "mapping/features/internal/descriptor_lanes.h"
#include "mapping/features/internal/extrema_lanes.h"
#include "mapping/features/internal/orientation_lanes.h"

namespace waymark::mapping::internal {

SiftKernels SiftKernelsAvx512() {
  using namespace WAYMARK_LANES;  // NOLINT: the one set of this file
  return {"AVX-512", DoubleRow,   FilterColumns,   BlurRows,
          Subtract,  FindExtrema, AddOrientations, Describe};
}

}  // namespace waymark::mapping::internal

#else

#include <cstdlib>

namespace waymark::mapping::internal {

SiftKernels SiftKernelsAvx512() {
  std::abort();  // never listed as supported
}

}  // namespace waymark::mapping::internal

#endif

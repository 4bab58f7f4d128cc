// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal {

/// The sets that this processor can run, fastest first; the last is the portable one.
std::span<const SiftKernels> SupportedSiftKernels();

}  // namespace waymark::mapping::internal

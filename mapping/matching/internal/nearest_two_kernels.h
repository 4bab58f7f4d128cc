// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "mapping/matching/descriptor_matching.h"

namespace waymark::mapping::internal {

/// One way to compute FindNearestTwo. All give identical results on every input.
struct NearestTwoKernel {
  std::string_view name;
  std::vector<NearestTwo> (*find)(std::span<const Descriptor> queries,
                                  std::span<const Descriptor> database);
};

/// The kernels that this processor can run, fastest first; the last is the portable one.
std::span<const NearestTwoKernel> SupportedNearestTwoKernels();

// Only for the list above: the first two end the process on processors without the instructions.
std::vector<NearestTwo> FindNearestTwoVnni(std::span<const Descriptor> queries,
                                           std::span<const Descriptor> database);
std::vector<NearestTwo> FindNearestTwoAvx2(std::span<const Descriptor> queries,
                                           std::span<const Descriptor> database);
std::vector<NearestTwo> FindNearestTwoPortable(std::span<const Descriptor> queries,
                                               std::span<const Descriptor> database);

}  // namespace waymark::mapping::internal

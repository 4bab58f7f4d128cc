// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/internal/nearest_two_kernels.h"

namespace waymark::mapping::internal {
namespace {

std::vector<NearestTwoKernel> ListSupported() {
  std::vector<NearestTwoKernel> kernels;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vnni")) {
    kernels.push_back({"AVX-512 VNNI", FindNearestTwoVnni});
  }
  if (__builtin_cpu_supports("avx2")) kernels.push_back({"AVX2", FindNearestTwoAvx2});
#endif
  kernels.push_back({"portable", FindNearestTwoPortable});
  return kernels;
}

}  // namespace

std::span<const NearestTwoKernel> SupportedNearestTwoKernels() {
  static const std::vector<NearestTwoKernel> kernels = ListSupported();
  return kernels;
}

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/sift_kernel_sets.h"

#include <vector>

namespace waymark::mapping::internal {
namespace {

std::vector<SiftKernels> ListSupported() {
  std::vector<SiftKernels> sets;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    sets.push_back(SiftKernelsAvx512());
  }
  if (__builtin_cpu_supports("avx2")) sets.push_back(SiftKernelsAvx2());
#endif
  sets.push_back(SiftKernelsPortable());
  return sets;
}

}  // namespace

std::span<const SiftKernels> SupportedSiftKernels() {
  static const std::vector<SiftKernels> sets = ListSupported();
  return sets;
}

}  // namespace waymark::mapping::internal

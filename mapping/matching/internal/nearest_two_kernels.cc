// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/internal/nearest_two_kernels.h"

#include <algorithm>
#include <array>
#include <numeric>

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

std::vector<NearestTwo> FindNearestTwo(const NearestTwoKernel& kernel,
                                       std::span<const Descriptor> queries,
                                       std::span<const Descriptor> database) {
  std::vector<std::uint32_t> all(std::max(queries.size(), database.size()));
  std::iota(all.begin(), all.end(), 0U);
  const std::array query_begins{0U, static_cast<std::uint32_t>(queries.size())};
  const std::array entry_begins{0U, static_cast<std::uint32_t>(database.size())};
  return kernel.find(queries, database,
                     {.query_begins = query_begins,
                      .queries = std::span(all).first(queries.size()),
                      .entry_begins = entry_begins,
                      .entries = std::span(all).first(database.size())});
}

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/group_kernels.h"

#include <algorithm>

#include "localiser/internal/clones.h"

namespace waymark::localiser::internal {
namespace {

__attribute__((always_inline)) inline void Dots(const DescriptorGroup& group,
                                                const PackedQuery& query, std::int32_t* dots) {
  for (std::size_t lane = 0; lane < kGroupLanes; ++lane) dots[lane] = query.offset;
  for (std::size_t step = 0; step < 32; ++step) {
    const std::uint8_t* four = query.descriptor->data() + 4 * step;
    for (std::size_t lane = 0; lane < kGroupLanes; ++lane) {
      const std::int8_t* entry = group.steps[step][lane];
      for (std::size_t k = 0; k < 4; ++k) dots[lane] += std::int32_t{four[k]} * entry[k];
    }
  }
}

WAYMARK_CLONES void MeetPortably(std::span<const DescriptorGroup> groups, std::int32_t first_group,
                                 std::span<const PackedQuery> queries,
                                 std::span<const std::uint32_t> chosen,
                                 std::span<LaneBest> states) {
  for (const std::uint32_t q : chosen) {
    LaneBest& state = states[q];
    for (std::size_t g = 0; g < groups.size(); ++g) {
      std::int32_t dots[kGroupLanes];
      Dots(groups[g], queries[q], dots);
      for (std::size_t lane = 0; lane < kGroupLanes; ++lane) {
        const std::int32_t first = state.first_dot[lane];
        const std::int32_t second = state.second_dot[lane];
        const std::int32_t number = first_group + static_cast<std::int32_t>(g);
        const bool is_first = dots[lane] > first, is_second = dots[lane] > second;
        state.second_dot[lane] = std::max(second, std::min(first, dots[lane]));
        state.second_group[lane] = is_first    ? state.first_group[lane]
                                   : is_second ? number
                                               : state.second_group[lane];
        state.first_dot[lane] = std::max(first, dots[lane]);
        state.first_group[lane] = is_first ? number : state.first_group[lane];
      }
    }
  }
}

WAYMARK_CLONES void DotsPortably(std::span<const DescriptorGroup> groups,
                                 std::span<const PackedQuery> queries, std::int32_t* dots) {
  for (const PackedQuery& query : queries) {
    for (const DescriptorGroup& group : groups) {
      Dots(group, query, dots);
      dots += kGroupLanes;
    }
  }
}

std::size_t AtLeastPortably(std::span<const std::int32_t> dots, std::int32_t bound,
                            std::uint32_t* indices) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < dots.size(); ++i) {
    indices[found] = static_cast<std::uint32_t>(i);
    found += dots[i] >= bound ? 1 : 0;
  }
  return found;
}

std::vector<GroupKernel> ListSupported() {
  std::vector<GroupKernel> kernels;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vnni")) {
    kernels.push_back(kVnniGroupKernel);
  }
#endif
  kernels.push_back(kPortableGroupKernel);
  return kernels;
}

}  // namespace

const GroupKernel kPortableGroupKernel{"portable", MeetPortably, DotsPortably, AtLeastPortably};

std::span<const GroupKernel> SupportedGroupKernels() {
  static const std::vector<GroupKernel> kernels = ListSupported();
  return kernels;
}

}  // namespace waymark::localiser::internal

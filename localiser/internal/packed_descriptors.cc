// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/packed_descriptors.h"

#include <algorithm>
#include <cstring>

#include "localiser/internal/group_kernels.h"
#include "mapping/base/check.h"

namespace waymark::localiser::internal {

void LaneBest::Clear() {
  std::fill_n(first_dot, kGroupLanes, -1);
  std::fill_n(second_dot, kGroupLanes, -1);
  std::fill_n(first_group, kGroupLanes, -1);
  std::fill_n(second_group, kGroupLanes, -1);
}

PackedQuery::PackedQuery(const mapping::Descriptor& asked) : descriptor(&asked), offset(0) {
  for (const std::uint8_t value : asked) offset += 128 * value;
}

DescriptorGroup EmptyGroup() {
  DescriptorGroup group;
  std::memset(&group, 0x80, sizeof(group));
  return group;
}

void PackInto(const mapping::Descriptor& descriptor, std::size_t lane, DescriptorGroup& group) {
  for (std::size_t step = 0; step < 32; ++step) {
    std::uint32_t four;
    std::memcpy(&four, descriptor.data() + 4 * step, 4);
    four ^= 0x80808080U;
    std::memcpy(group.steps[step][lane], &four, 4);
  }
}

void MeetGroups(std::span<const DescriptorGroup> groups, std::int32_t first_group,
                std::span<const PackedQuery> queries, std::span<const std::uint32_t> chosen,
                std::span<LaneBest> states) {
  CHECK(queries.size() == states.size());
  SupportedGroupKernels().front().meet(groups, first_group, queries, chosen, states);
}

std::int32_t BestOfAnother(std::span<const DescriptorGroup> groups,
                           std::span<const std::uint32_t> landmarks, const PackedQuery& query,
                           std::uint32_t landmark) {
  CHECK(landmarks.size() == groups.size() * kGroupLanes);
  constexpr std::size_t kTogether = 8;
  std::int32_t best = -1;
  std::int32_t dots[kTogether * kGroupLanes];
  const auto compute = SupportedGroupKernels().front().dots;
  for (std::size_t g = 0; g < groups.size(); g += kTogether) {
    const auto some = groups.subspan(g, std::min(kTogether, groups.size() - g));
    compute(some, std::span(&query, 1), dots);
    for (std::size_t i = 0; i < some.size() * kGroupLanes; ++i) {
      if (landmarks[g * kGroupLanes + i] != landmark) best = std::max(best, dots[i]);
    }
  }
  return best;
}

void ComputeDots(std::span<const DescriptorGroup> groups, std::span<const PackedQuery> queries,
                 std::span<std::int32_t> dots) {
  CHECK(dots.size() == queries.size() * groups.size() * kGroupLanes);
  SupportedGroupKernels().front().dots(groups, queries, dots.data());
}

}  // namespace waymark::localiser::internal

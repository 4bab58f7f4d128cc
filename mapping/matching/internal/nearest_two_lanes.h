// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/matching/descriptor_matching.h"

namespace waymark::mapping::internal {

/// The best two of one query in each register lane; lane l has seen entries l, l + kLanes, …
template <std::size_t kLanes>
struct LaneState {
  LaneState() {
    std::fill_n(first_dot, kLanes, -1);
    std::fill_n(second_dot, kLanes, -1);
    std::fill_n(first, kLanes, -1);
  }

  alignas(4 * kLanes) std::int32_t first_dot[kLanes];
  alignas(4 * kLanes) std::int32_t second_dot[kLanes];
  alignas(4 * kLanes) std::int32_t first[kLanes];  ///< entry divided by kLanes; -1: none yet
};

/// The best two over all lanes; ties go to the lower entry.
template <std::size_t kLanes>
NearestTwo MergeLanes(const LaneState<kLanes>& state) {
  NearestTwo answer;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (state.first[lane] < 0) continue;
    const auto entry = static_cast<std::uint32_t>(state.first[lane] * kLanes + lane);
    const std::int32_t dot = state.first_dot[lane];
    if (dot > answer.first_dot || (dot == answer.first_dot && entry < answer.first)) {
      answer.second_dot = std::max(answer.second_dot, answer.first_dot);
      answer.first_dot = dot;
      answer.first = entry;
    } else {
      answer.second_dot = std::max(answer.second_dot, dot);
    }
    answer.second_dot = std::max(answer.second_dot, state.second_dot[lane]);
  }
  return answer;
}

template <std::size_t kLanes>
std::vector<NearestTwo> MergeLanes(std::span<const LaneState<kLanes>> states, std::size_t count) {
  std::vector<NearestTwo> answers(count);
  for (std::size_t q = 0; q < count; ++q) answers[q] = MergeLanes(states[q]);
  return answers;
}

}  // namespace waymark::mapping::internal

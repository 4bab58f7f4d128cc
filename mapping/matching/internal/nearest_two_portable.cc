// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/internal/nearest_two_kernels.h"

namespace waymark::mapping::internal {
namespace {

std::int32_t Dot(const Descriptor& a, const Descriptor& b) {
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::int32_t{a[i]} * std::int32_t{b[i]};
  return sum;
}

}  // namespace

std::vector<NearestTwo> FindNearestTwoPortable(std::span<const Descriptor> queries,
                                               std::span<const Descriptor> database) {
  std::vector<NearestTwo> answers(queries.size());
  for (std::size_t q = 0; q < queries.size(); ++q) {
    NearestTwo& answer = answers[q];
    for (std::size_t d = 0; d < database.size(); ++d) {
      const std::int32_t dot = Dot(queries[q], database[d]);
      if (dot > answer.first_dot) {
        answer = {static_cast<std::uint32_t>(d), dot, answer.first_dot};
      } else if (dot > answer.second_dot) {
        answer.second_dot = dot;
      }
    }
  }
  return answers;
}

}  // namespace waymark::mapping::internal

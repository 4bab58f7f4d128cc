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
                                               std::span<const Descriptor> database,
                                               const SearchCells& cells) {
  std::vector<NearestTwo> answers(queries.size());
  for (std::size_t cell = 0; cell + 1 < cells.entry_begins.size(); ++cell) {
    for (std::uint32_t i = cells.query_begins[cell]; i < cells.query_begins[cell + 1]; ++i) {
      const std::uint32_t query = cells.queries[i];
      NearestTwo& answer = answers[query];
      for (std::uint32_t j = cells.entry_begins[cell]; j < cells.entry_begins[cell + 1]; ++j) {
        const std::uint32_t entry = cells.entries[j];
        const std::int32_t dot = Dot(queries[query], database[entry]);
        if (dot > answer.first_dot) {
          answer = {entry, dot, answer.first_dot};
        } else if (dot > answer.second_dot) {
          answer.second_dot = dot;
        }
      }
    }
  }
  return answers;
}

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mapping/matching/internal/nearest_two_kernels.h"

namespace waymark::mapping::internal {

/// The best two of one query in each lane of a register. Each cell of entries begins a register.
template <std::size_t kLanes>
struct LaneState {
  LaneState() {
    std::fill_n(first_dot, kLanes, -1);
    std::fill_n(second_dot, kLanes, -1);
    std::fill_n(first, kLanes, -1);
  }

  alignas(4 * kLanes) std::int32_t first_dot[kLanes];
  alignas(4 * kLanes) std::int32_t second_dot[kLanes];
  alignas(4 * kLanes) std::int32_t first[kLanes];  ///< number of the register; -1: none yet
};

/// The best two over all lanes, the first as its place in the list of entries; ties go to the
/// earlier place. `register_places`: where the entries of each register begin in that list.
template <std::size_t kLanes>
NearestTwo MergeLanes(const LaneState<kLanes>& state,
                      std::span<const std::uint32_t> register_places) {
  NearestTwo answer;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (state.first[lane] < 0) continue;
    const std::uint32_t place = register_places[static_cast<std::size_t>(state.first[lane])] +
                                static_cast<std::uint32_t>(lane);
    const std::int32_t dot = state.first_dot[lane];
    if (dot > answer.first_dot || (dot == answer.first_dot && place < answer.first)) {
      answer.second_dot = std::max(answer.second_dot, answer.first_dot);
      answer.first_dot = dot;
      answer.first = place;
    } else {
      answer.second_dot = std::max(answer.second_dot, dot);
    }
    answer.second_dot = std::max(answer.second_dot, state.second_dot[lane]);
  }
  return answer;
}

/// Walks through the cells. A `Kernel` packs up to kBlockEntries entries and compares a tile of
/// kTileQueries queries with them; it is made from all queries, and its states are apart.
template <typename Kernel>
std::vector<NearestTwo> SearchInCells(std::span<const Descriptor> queries,
                                      std::span<const Descriptor> database,
                                      const SearchCells& cells) {
  using State = LaneState<Kernel::kLanes>;
  Kernel kernel(queries);
  std::vector<State> states(queries.size() + 1);  // the last takes what fills up a tile
  std::vector<std::uint32_t> register_places;
  for (std::size_t cell = 0; cell + 1 < cells.entry_begins.size(); ++cell) {
    const std::uint32_t query_begin = cells.query_begins[cell];
    const std::uint32_t query_end = cells.query_begins[cell + 1];
    if (query_begin == query_end) continue;
    std::uint32_t begin = cells.entry_begins[cell];
    for (const std::uint32_t end = cells.entry_begins[cell + 1]; begin < end;) {
      const std::size_t count = std::min<std::size_t>(Kernel::kBlockEntries, end - begin);
      kernel.Pack(database, cells.entries.subspan(begin, count));
      const auto first_register = static_cast<std::int32_t>(register_places.size());
      for (std::size_t e = 0; e < count; e += Kernel::kLanes) {
        register_places.push_back(begin + static_cast<std::uint32_t>(e));
      }
      for (std::uint32_t q = query_begin; q < query_end; q += Kernel::kTileQueries) {
        std::uint32_t tile[Kernel::kTileQueries];
        State* tile_states[Kernel::kTileQueries];
        for (std::uint32_t i = 0; i < Kernel::kTileQueries; ++i) {
          const bool exists = q + i < query_end;
          tile[i] = cells.queries[exists ? q + i : q];
          tile_states[i] = exists ? &states[tile[i]] : &states.back();
        }
        kernel.Scan(tile, first_register, count, tile_states);
      }
      begin += static_cast<std::uint32_t>(count);
    }
  }
  std::vector<NearestTwo> answers(queries.size());
  for (std::size_t q = 0; q < queries.size(); ++q) {
    answers[q] = MergeLanes<Kernel::kLanes>(states[q], register_places);
    if (answers[q].first_dot >= 0) answers[q].first = cells.entries[answers[q].first];
  }
  return answers;
}

}  // namespace waymark::mapping::internal

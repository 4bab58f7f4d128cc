// SPDX-License-Identifier: Apache-2.0
// No Eigen here: code for wider registers must not share its types (alignment differs).
#include <cstdlib>
#include <cstring>

#include "mapping/matching/internal/nearest_two_kernels.h"

#if defined(__x86_64__)
#if defined(__clang__)
#include <immintrin.h>
#else  // g++ 12 takes the deliberately undefined registers of its header for a mistake (bug 105593)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#endif

#include "mapping/matching/internal/nearest_two_lanes.h"

#define WAYMARK_VNNI __attribute__((target("avx512f,avx512bw,avx512vnni")))

namespace waymark::mapping::internal {
namespace {

// Sixteen database entries lie side by side in one register, one per 32-bit lane, four components
// at a time, so that every lane accumulates its own dot product and nothing is summed across.
// A tile is four queries times four such registers: sixteen accumulators, eight loads per step.
constexpr std::size_t kLanes = 16;
constexpr std::size_t kTileQueries = 4;
constexpr std::size_t kTileRegisters = 4;
constexpr std::size_t kTileEntries = kLanes * kTileRegisters;
constexpr std::size_t kSteps = std::tuple_size_v<Descriptor> / 4;
constexpr std::size_t kBlockTiles = 2;  ///< 16 KiB of packed entries stay in the first cache
constexpr std::size_t kBlockEntries = kTileEntries * kBlockTiles;

using State = LaneState<kLanes>;

/// vpdpbusd multiplies unsigned by signed bytes, so entries are stored minus 128; the difference,
/// 128 times the sum of the query, starts the accumulators.
struct PackedBlock {
  alignas(64) std::int8_t tiles[kBlockTiles][kSteps][kTileRegisters][kLanes][4];
};

void Pack(std::span<const Descriptor> entries, PackedBlock& block) {
  for (std::size_t e = 0; e < entries.size(); ++e) {
    auto& tile = block.tiles[e / kTileEntries];
    for (std::size_t k = 0; k < kSteps; ++k) {
      std::uint32_t four;
      std::memcpy(&four, entries[e].data() + 4 * k, 4);
      four ^= 0x80808080U;
      std::memcpy(tile[k][e / kLanes % kTileRegisters][e % kLanes], &four, 4);
    }
  }
}

std::int32_t Sum(const Descriptor& descriptor) {
  std::int32_t sum = 0;
  for (const std::uint8_t value : descriptor) sum += value;
  return sum;
}

/// One query against sixteen entries of which the first `valid` exist.
WAYMARK_VNNI inline void Update(State& state, __m512i dots, std::int32_t index, __mmask16 valid) {
  const __m512i first = _mm512_load_si512(state.first_dot);
  const __m512i second = _mm512_load_si512(state.second_dot);
  dots = _mm512_mask_mov_epi32(_mm512_set1_epi32(-1), valid, dots);
  const __mmask16 better = _mm512_cmpgt_epi32_mask(dots, first);
  _mm512_store_si512(state.second_dot, _mm512_max_epi32(second, _mm512_min_epi32(first, dots)));
  _mm512_store_si512(state.first_dot, _mm512_max_epi32(first, dots));
  _mm512_mask_store_epi32(state.first, better, _mm512_set1_epi32(index));
}

WAYMARK_VNNI void Scan(const Descriptor* const (&queries)[kTileQueries],
                       const std::int32_t (&offsets)[kTileQueries], const PackedBlock& block,
                       std::size_t entry_count, std::int32_t block_index, State* states) {
  for (std::size_t t = 0; t * kTileEntries < entry_count; ++t) {
    __m512i dots[kTileQueries][kTileRegisters];
    for (std::size_t q = 0; q < kTileQueries; ++q) {
      for (auto& lane_dots : dots[q]) lane_dots = _mm512_set1_epi32(offsets[q]);
    }
    for (std::size_t k = 0; k < kSteps; ++k) {
      __m512i entries[kTileRegisters];
#pragma GCC unroll 4
      for (std::size_t r = 0; r < kTileRegisters; ++r) {
        entries[r] = _mm512_load_si512(block.tiles[t][k][r]);
      }
#pragma GCC unroll 4
      for (std::size_t q = 0; q < kTileQueries; ++q) {
        std::int32_t four;
        std::memcpy(&four, queries[q]->data() + 4 * k, 4);
        const __m512i query = _mm512_set1_epi32(four);
#pragma GCC unroll 4
        for (std::size_t r = 0; r < kTileRegisters; ++r) {
          dots[q][r] = _mm512_dpbusd_epi32(dots[q][r], query, entries[r]);
        }
      }
    }
    for (std::size_t r = 0; r < kTileRegisters; ++r) {
      const std::size_t begin = t * kTileEntries + r * kLanes;
      if (begin >= entry_count) break;
      const std::size_t left = entry_count - begin;
      const auto valid = static_cast<__mmask16>(left >= kLanes ? 0xffffU : (1U << left) - 1);
      const auto index = static_cast<std::int32_t>(block_index + begin / kLanes);
      for (std::size_t q = 0; q < kTileQueries; ++q) Update(states[q], dots[q][r], index, valid);
    }
  }
}

}  // namespace

std::vector<NearestTwo> FindNearestTwoVnni(std::span<const Descriptor> queries,
                                           std::span<const Descriptor> database) {
  const std::size_t padded = (queries.size() + kTileQueries - 1) / kTileQueries * kTileQueries;
  std::vector<State> states(padded);
  std::vector<std::int32_t> offsets(padded);
  for (std::size_t q = 0; q < queries.size(); ++q) offsets[q] = 128 * Sum(queries[q]);
  PackedBlock block{};
  for (std::size_t d = 0; d < database.size(); d += kBlockEntries) {
    const auto entries = database.subspan(d, std::min(kBlockEntries, database.size() - d));
    Pack(entries, block);
    for (std::size_t q = 0; q < queries.size(); q += kTileQueries) {
      const Descriptor* tile[kTileQueries];
      std::int32_t tile_offsets[kTileQueries];
      for (std::size_t i = 0; i < kTileQueries; ++i) {
        tile[i] = &queries[std::min(q + i, queries.size() - 1)];
        tile_offsets[i] = offsets[q + i];
      }
      Scan(tile, tile_offsets, block, entries.size(), static_cast<std::int32_t>(d / kLanes),
           &states[q]);
    }
  }
  return MergeLanes<kLanes>(states, queries.size());
}

}  // namespace waymark::mapping::internal

#else

namespace waymark::mapping::internal {

std::vector<NearestTwo> FindNearestTwoVnni(std::span<const Descriptor>,
                                           std::span<const Descriptor>) {
  std::abort();  // never listed as supported
}

}  // namespace waymark::mapping::internal

#endif

// SPDX-License-Identifier: Apache-2.0
// No Eigen here: code for wider registers must not share its types (alignment differs).
#include <cstdlib>
#include <cstring>

#include "mapping/matching/internal/nearest_two_kernels.h"

#if defined(__x86_64__)
#include <immintrin.h>

#include "mapping/matching/internal/nearest_two_lanes.h"

#define WAYMARK_AVX2 __attribute__((target("avx2")))

namespace waymark::mapping::internal {
namespace {

// Eight database entries lie side by side, one per 32-bit lane, two 16-bit components at a time:
// vpmaddubsw would be half the work but saturates on 8-bit descriptors.
// A tile is four queries times two such registers: eight accumulators.
constexpr std::size_t kLanes = 8;
constexpr std::size_t kTileQueries = 4;
constexpr std::size_t kTileRegisters = 2;
constexpr std::size_t kTileEntries = kLanes * kTileRegisters;
constexpr std::size_t kSteps = std::tuple_size_v<Descriptor> / 2;
constexpr std::size_t kBlockTiles = 4;  ///< 16 KiB of packed entries stay in the first cache
constexpr std::size_t kBlockEntries = kTileEntries * kBlockTiles;

using State = LaneState<kLanes>;
using WideDescriptor = std::array<std::int16_t, std::tuple_size_v<Descriptor>>;

struct PackedBlock {
  alignas(32) std::int16_t tiles[kBlockTiles][kSteps][kTileRegisters][kLanes][2];
};

void Pack(std::span<const Descriptor> entries, PackedBlock& block) {
  for (std::size_t e = 0; e < entries.size(); ++e) {
    auto& tile = block.tiles[e / kTileEntries];
    for (std::size_t k = 0; k < kSteps; ++k) {
      auto& two = tile[k][e / kLanes % kTileRegisters][e % kLanes];
      two[0] = entries[e][2 * k];
      two[1] = entries[e][2 * k + 1];
    }
  }
}

WAYMARK_AVX2 inline __m256i Load(const void* from) {
  return _mm256_load_si256(static_cast<const __m256i*>(from));
}

WAYMARK_AVX2 inline void Store(void* to, __m256i value) {
  _mm256_store_si256(static_cast<__m256i*>(to), value);
}

/// One query against eight entries; those in lanes at or above `valid` do not exist.
WAYMARK_AVX2 inline void Update(State& state, __m256i dots, std::int32_t index, int valid) {
  const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i exists = _mm256_cmpgt_epi32(_mm256_set1_epi32(valid), lanes);
  dots = _mm256_or_si256(dots, _mm256_xor_si256(exists, _mm256_set1_epi32(-1)));  // else -1
  const __m256i first = Load(state.first_dot);
  const __m256i better = _mm256_cmpgt_epi32(dots, first);
  Store(state.second_dot, _mm256_max_epi32(Load(state.second_dot), _mm256_min_epi32(first, dots)));
  Store(state.first_dot, _mm256_max_epi32(first, dots));
  Store(state.first, _mm256_blendv_epi8(Load(state.first), _mm256_set1_epi32(index), better));
}

WAYMARK_AVX2 void Scan(const WideDescriptor* queries, const PackedBlock& block,
                       std::size_t entry_count, std::int32_t block_index, State* states) {
  for (std::size_t t = 0; t * kTileEntries < entry_count; ++t) {
    __m256i dots[kTileQueries][kTileRegisters] = {};
    for (std::size_t k = 0; k < kSteps; ++k) {
      __m256i entries[kTileRegisters];
#pragma GCC unroll 4
      for (std::size_t r = 0; r < kTileRegisters; ++r) {
        entries[r] = Load(block.tiles[t][k][r]);
      }
#pragma GCC unroll 4
      for (std::size_t q = 0; q < kTileQueries; ++q) {
        std::int32_t two;
        std::memcpy(&two, queries[q].data() + 2 * k, 4);
        const __m256i query = _mm256_set1_epi32(two);
#pragma GCC unroll 4
        for (std::size_t r = 0; r < kTileRegisters; ++r) {
          dots[q][r] = _mm256_add_epi32(dots[q][r], _mm256_madd_epi16(query, entries[r]));
        }
      }
    }
    for (std::size_t r = 0; r < kTileRegisters; ++r) {
      const std::size_t begin = t * kTileEntries + r * kLanes;
      if (begin >= entry_count) break;
      const auto valid = static_cast<int>(std::min(entry_count - begin, kLanes));
      const auto index = static_cast<std::int32_t>(block_index + begin / kLanes);
      for (std::size_t q = 0; q < kTileQueries; ++q) Update(states[q], dots[q][r], index, valid);
    }
  }
}

}  // namespace

std::vector<NearestTwo> FindNearestTwoAvx2(std::span<const Descriptor> queries,
                                           std::span<const Descriptor> database) {
  const std::size_t padded = (queries.size() + kTileQueries - 1) / kTileQueries * kTileQueries;
  std::vector<State> states(padded);
  std::vector<WideDescriptor> wide(padded);
  for (std::size_t q = 0; q < queries.size(); ++q) {
    std::copy(queries[q].begin(), queries[q].end(), wide[q].begin());
  }
  PackedBlock block{};
  for (std::size_t d = 0; d < database.size(); d += kBlockEntries) {
    const auto entries = database.subspan(d, std::min(kBlockEntries, database.size() - d));
    Pack(entries, block);
    for (std::size_t q = 0; q < padded; q += kTileQueries) {
      Scan(&wide[q], block, entries.size(), static_cast<std::int32_t>(d / kLanes), &states[q]);
    }
  }
  return MergeLanes<kLanes>(states, queries.size());
}

}  // namespace waymark::mapping::internal

#else

namespace waymark::mapping::internal {

std::vector<NearestTwo> FindNearestTwoAvx2(std::span<const Descriptor>,
                                           std::span<const Descriptor>) {
  std::abort();  // never listed as supported
}

}  // namespace waymark::mapping::internal

#endif

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

using WideDescriptor = std::array<std::int16_t, std::tuple_size_v<Descriptor>>;

/// Entries of one tile, by two components, register, lane.
using PackedTile = std::int16_t[kSteps][kTileRegisters][kLanes][2];

struct Tile {
  const std::int16_t* queries[kTileQueries];
  LaneState<kLanes>* states[kTileQueries];
};

WAYMARK_AVX2 inline __m256i Load(const void* from) {
  return _mm256_load_si256(static_cast<const __m256i*>(from));
}

WAYMARK_AVX2 inline void Store(void* to, __m256i value) {
  _mm256_store_si256(static_cast<__m256i*>(to), value);
}

/// One query against eight entries; those in lanes at or above `valid` do not exist.
WAYMARK_AVX2 inline void Update(LaneState<kLanes>& state, __m256i dots, std::int32_t place,
                                int valid) {
  const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i exists = _mm256_cmpgt_epi32(_mm256_set1_epi32(valid), lanes);
  dots = _mm256_or_si256(dots, _mm256_xor_si256(exists, _mm256_set1_epi32(-1)));  // else -1
  const __m256i first = Load(state.first_dot);
  const __m256i better = _mm256_cmpgt_epi32(dots, first);
  Store(state.second_dot, _mm256_max_epi32(Load(state.second_dot), _mm256_min_epi32(first, dots)));
  Store(state.first_dot, _mm256_max_epi32(first, dots));
  Store(state.first, _mm256_blendv_epi8(Load(state.first), _mm256_set1_epi32(place), better));
}

WAYMARK_AVX2 void ScanTile(const Tile& tile, const PackedTile& packed, std::int32_t first_register,
                           std::size_t count) {
  __m256i dots[kTileQueries][kTileRegisters] = {};
  for (std::size_t k = 0; k < kSteps; ++k) {
    __m256i entries[kTileRegisters];
#pragma GCC unroll 4
    for (std::size_t r = 0; r < kTileRegisters; ++r) entries[r] = Load(packed[k][r]);
#pragma GCC unroll 4
    for (std::size_t q = 0; q < kTileQueries; ++q) {
      std::int32_t two;
      std::memcpy(&two, tile.queries[q] + 2 * k, 4);
      const __m256i query = _mm256_set1_epi32(two);
#pragma GCC unroll 4
      for (std::size_t r = 0; r < kTileRegisters; ++r) {
        dots[q][r] = _mm256_add_epi32(dots[q][r], _mm256_madd_epi16(query, entries[r]));
      }
    }
  }
  for (std::size_t r = 0; r * kLanes < count; ++r) {
    const auto valid = static_cast<int>(std::min(count - r * kLanes, kLanes));
    const std::int32_t place = first_register + static_cast<std::int32_t>(r);
    for (std::size_t q = 0; q < kTileQueries; ++q) {
      Update(*tile.states[q], dots[q][r], place, valid);
    }
  }
}

class Kernel {
 public:
  static constexpr std::size_t kLanes = internal::kLanes;
  static constexpr std::size_t kTileQueries = internal::kTileQueries;
  static constexpr std::size_t kBlockEntries = kTileEntries * kBlockTiles;

  explicit Kernel(std::span<const Descriptor> queries) : queries_(queries.size()) {
    for (std::size_t q = 0; q < queries.size(); ++q) {
      std::copy(queries[q].begin(), queries[q].end(), queries_[q].begin());
    }
  }

  void Pack(std::span<const Descriptor> database, std::span<const std::uint32_t> entries) {
    for (std::size_t e = 0; e < entries.size(); ++e) {
      PackedTile& tile = tiles_[e / kTileEntries];
      const Descriptor& entry = database[entries[e]];
      for (std::size_t k = 0; k < kSteps; ++k) {
        auto& two = tile[k][e / kLanes % kTileRegisters][e % kLanes];
        two[0] = entry[2 * k];
        two[1] = entry[2 * k + 1];
      }
    }
  }

  void Scan(const std::uint32_t (&queries)[kTileQueries], std::int32_t first_register,
            std::size_t entry_count, LaneState<kLanes>* const (&states)[kTileQueries]) const {
    Tile tile;
    for (std::size_t q = 0; q < kTileQueries; ++q) {
      tile.queries[q] = queries_[queries[q]].data();
      tile.states[q] = states[q];
    }
    for (std::size_t t = 0; t * kTileEntries < entry_count; ++t) {
      ScanTile(tile, tiles_[t], first_register + static_cast<std::int32_t>(t * kTileRegisters),
               std::min(entry_count - t * kTileEntries, kTileEntries));
    }
  }

 private:
  std::vector<WideDescriptor> queries_;
  alignas(32) PackedTile tiles_[kBlockTiles] = {};
};

}  // namespace

std::vector<NearestTwo> FindNearestTwoAvx2(std::span<const Descriptor> queries,
                                           std::span<const Descriptor> database,
                                           const SearchCells& cells) {
  return SearchInCells<Kernel>(queries, database, cells);
}

}  // namespace waymark::mapping::internal

#else

namespace waymark::mapping::internal {

std::vector<NearestTwo> FindNearestTwoAvx2(std::span<const Descriptor>, std::span<const Descriptor>,
                                           const SearchCells&) {
  std::abort();  // never listed as supported
}

}  // namespace waymark::mapping::internal

#endif

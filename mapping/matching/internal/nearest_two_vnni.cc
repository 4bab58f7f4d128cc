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
#pragma GCC diagnostic ignored "-Wuninitialized"
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

std::int32_t Sum(const Descriptor& descriptor) {
  std::int32_t sum = 0;
  for (const std::uint8_t value : descriptor) sum += value;
  return sum;
}

/// Entries of one tile, by four components, register, lane.
using PackedTile = std::int8_t[kSteps][kTileRegisters][kLanes][4];

struct Tile {
  const std::uint8_t* queries[kTileQueries];
  std::int32_t offsets[kTileQueries];
  LaneState<kLanes>* states[kTileQueries];
};

/// The first `kRegisters` registers of entries, of which the last holds `last_valid`.
template <std::size_t kRegisters>
WAYMARK_VNNI inline void ScanTile(const Tile& tile, const PackedTile& packed,
                                  std::int32_t first_register, __mmask16 last_valid) {
  __m512i dots[kTileQueries][kRegisters];
#pragma GCC unroll 4
  for (std::size_t q = 0; q < kTileQueries; ++q) {
#pragma GCC unroll 4
    for (std::size_t r = 0; r < kRegisters; ++r) dots[q][r] = _mm512_set1_epi32(tile.offsets[q]);
  }
  for (std::size_t k = 0; k < kSteps; ++k) {
    __m512i entries[kRegisters];
#pragma GCC unroll 4
    for (std::size_t r = 0; r < kRegisters; ++r) entries[r] = _mm512_load_si512(packed[k][r]);
#pragma GCC unroll 4
    for (std::size_t q = 0; q < kTileQueries; ++q) {
      std::int32_t four;
      std::memcpy(&four, tile.queries[q] + 4 * k, 4);
      const __m512i query = _mm512_set1_epi32(four);
#pragma GCC unroll 4
      for (std::size_t r = 0; r < kRegisters; ++r) {
        dots[q][r] = _mm512_dpbusd_epi32(dots[q][r], query, entries[r]);
      }
    }
  }
#pragma GCC unroll 4
  for (std::size_t q = 0; q < kTileQueries; ++q) {
    LaneState<kLanes>& state = *tile.states[q];
    __m512i first_dot = _mm512_load_si512(state.first_dot);
    __m512i second_dot = _mm512_load_si512(state.second_dot);
    __m512i first = _mm512_load_si512(state.first);
    dots[q][kRegisters - 1] =
        _mm512_mask_mov_epi32(_mm512_set1_epi32(-1), last_valid, dots[q][kRegisters - 1]);
#pragma GCC unroll 4
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const __m512i dot = dots[q][r];
      const __mmask16 better = _mm512_cmpgt_epi32_mask(dot, first_dot);
      second_dot = _mm512_max_epi32(second_dot, _mm512_min_epi32(first_dot, dot));
      first_dot = _mm512_max_epi32(first_dot, dot);
      first = _mm512_mask_mov_epi32(first, better,
                                    _mm512_set1_epi32(first_register + static_cast<int>(r)));
    }
    _mm512_store_si512(state.first_dot, first_dot);
    _mm512_store_si512(state.second_dot, second_dot);
    _mm512_store_si512(state.first, first);
  }
}

WAYMARK_VNNI void ScanEntries(const Tile& tile, const PackedTile* packed,
                              std::int32_t first_register, std::size_t count) {
  for (; count > 0; ++packed, first_register += static_cast<int>(kTileRegisters)) {
    const std::size_t here = std::min(count, kTileEntries);
    const std::size_t registers = (here + kLanes - 1) / kLanes;
    const auto last_valid = static_cast<__mmask16>(0xffffU >> (registers * kLanes - here));
    switch (registers) {
      case 1:
        ScanTile<1>(tile, *packed, first_register, last_valid);
        break;
      case 2:
        ScanTile<2>(tile, *packed, first_register, last_valid);
        break;
      case 3:
        ScanTile<3>(tile, *packed, first_register, last_valid);
        break;
      default:
        ScanTile<4>(tile, *packed, first_register, last_valid);
    }
    count -= here;
  }
}

/// vpdpbusd multiplies unsigned by signed bytes, so entries are stored minus 128; the difference,
/// 128 times the sum of the query, starts the accumulators.
class Kernel {
 public:
  static constexpr std::size_t kLanes = internal::kLanes;
  static constexpr std::size_t kTileQueries = internal::kTileQueries;
  static constexpr std::size_t kBlockEntries = kTileEntries * kBlockTiles;

  explicit Kernel(std::span<const Descriptor> queries) : queries_(queries) {
    offsets_.reserve(queries.size());
    for (const Descriptor& query : queries) offsets_.push_back(128 * Sum(query));
  }

  void Pack(std::span<const Descriptor> database, std::span<const std::uint32_t> entries) {
    for (std::size_t e = 0; e < entries.size(); ++e) {
      PackedTile& tile = tiles_[e / kTileEntries];
      for (std::size_t k = 0; k < kSteps; ++k) {
        std::uint32_t four;
        std::memcpy(&four, database[entries[e]].data() + 4 * k, 4);
        four ^= 0x80808080U;
        std::memcpy(tile[k][e / kLanes % kTileRegisters][e % kLanes], &four, 4);
      }
    }
  }

  void Scan(const std::uint32_t (&queries)[kTileQueries], std::int32_t first_register,
            std::size_t entry_count, LaneState<kLanes>* const (&states)[kTileQueries]) const {
    Tile tile;
    for (std::size_t q = 0; q < kTileQueries; ++q) {
      tile.queries[q] = queries_[queries[q]].data();
      tile.offsets[q] = offsets_[queries[q]];
      tile.states[q] = states[q];
    }
    ScanEntries(tile, tiles_, first_register, entry_count);
  }

 private:
  std::span<const Descriptor> queries_;
  std::vector<std::int32_t> offsets_;
  alignas(64) PackedTile tiles_[kBlockTiles] = {};
};

}  // namespace

std::vector<NearestTwo> FindNearestTwoVnni(std::span<const Descriptor> queries,
                                           std::span<const Descriptor> database,
                                           const SearchCells& cells) {
  return SearchInCells<Kernel>(queries, database, cells);
}

}  // namespace waymark::mapping::internal

#else

namespace waymark::mapping::internal {

std::vector<NearestTwo> FindNearestTwoVnni(std::span<const Descriptor>, std::span<const Descriptor>,
                                           const SearchCells&) {
  std::abort();  // never listed as supported
}

}  // namespace waymark::mapping::internal

#endif

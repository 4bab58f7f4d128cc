// SPDX-License-Identifier: Apache-2.0
// No Eigen here: code for wider registers must not share its types (alignment differs).
#include <cstdlib>
#include <cstring>

#include "localiser/internal/group_kernels.h"

#if defined(__x86_64__)
#if !defined(__clang__)
// g++ 12 takes the deliberately undefined registers of its header for a mistake (bug 105593), also
// where it has inlined them below.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif
#include <immintrin.h>

#define WAYMARK_VNNI __attribute__((target("avx512f,avx512bw,avx512vnni")))

namespace waymark::localiser::internal {
namespace {

WAYMARK_VNNI inline void Update(LaneBest& state, __m512i dots, std::int32_t group) {
  const __m512i first = _mm512_load_si512(state.first_dot);
  const __m512i second = _mm512_load_si512(state.second_dot);
  const __mmask16 is_better = _mm512_cmpgt_epi32_mask(dots, first);
  _mm512_store_si512(state.second_dot, _mm512_max_epi32(second, _mm512_min_epi32(first, dots)));
  _mm512_store_si512(state.first_dot, _mm512_max_epi32(first, dots));
  _mm512_mask_store_epi32(state.group, is_better, _mm512_set1_epi32(group));
}

WAYMARK_VNNI inline __m512i Broadcast(const PackedQuery& query, std::size_t step) {
  std::int32_t four;
  std::memcpy(&four, query.descriptor->data() + 4 * step, 4);
  return _mm512_set1_epi32(four);
}

/// A tile: some queries times some groups, an accumulator each, so that loads are shared.
template <std::size_t kQueries, std::size_t kGroups>
WAYMARK_VNNI inline void MeetTile(const DescriptorGroup* groups, std::int32_t first_group,
                                  std::span<const PackedQuery> queries, const std::uint32_t* chosen,
                                  std::span<LaneBest> states) {
  __m512i dots[kQueries][kGroups];
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueries; ++q) {
#pragma GCC unroll 4
    for (std::size_t g = 0; g < kGroups; ++g) {
      dots[q][g] = _mm512_set1_epi32(queries[chosen[q]].offset);
    }
  }
  for (std::size_t step = 0; step < 32; ++step) {
    __m512i entries[kGroups];
#pragma GCC unroll 4
    for (std::size_t g = 0; g < kGroups; ++g) {
      entries[g] = _mm512_load_si512(groups[g].steps[step]);
    }
#pragma GCC unroll 8
    for (std::size_t q = 0; q < kQueries; ++q) {
      const __m512i query = Broadcast(queries[chosen[q]], step);
#pragma GCC unroll 4
      for (std::size_t g = 0; g < kGroups; ++g) {
        dots[q][g] = _mm512_dpbusd_epi32(dots[q][g], query, entries[g]);
      }
    }
  }
  for (std::size_t q = 0; q < kQueries; ++q) {
    for (std::size_t g = 0; g < kGroups; ++g) {
      Update(states[chosen[q]], dots[q][g], first_group + static_cast<std::int32_t>(g));
    }
  }
}

template <std::size_t kQueries>
WAYMARK_VNNI void MeetAll(std::span<const DescriptorGroup> groups, std::int32_t first_group,
                          std::span<const PackedQuery> queries, const std::uint32_t* chosen,
                          std::span<LaneBest> states) {
  std::size_t g = 0;
  for (; g + 2 <= groups.size(); g += 2) {
    MeetTile<kQueries, 2>(&groups[g], first_group + static_cast<std::int32_t>(g), queries, chosen,
                          states);
  }
  if (g < groups.size()) {
    MeetTile<kQueries, 1>(&groups[g], first_group + static_cast<std::int32_t>(g), queries, chosen,
                          states);
  }
}

void Meet(std::span<const DescriptorGroup> groups, std::int32_t first_group,
          std::span<const PackedQuery> queries, std::span<const std::uint32_t> chosen,
          std::span<LaneBest> states) {
  std::size_t q = 0;
  for (; q + 4 <= chosen.size(); q += 4) {
    MeetAll<4>(groups, first_group, queries, &chosen[q], states);
  }
  for (; q < chosen.size(); ++q) MeetAll<1>(groups, first_group, queries, &chosen[q], states);
}

WAYMARK_VNNI void Dots(std::span<const DescriptorGroup> groups, const PackedQuery& query,
                       std::int32_t* dots) {
  std::size_t g = 0;
  for (; g + 4 <= groups.size(); g += 4) {
    __m512i sums[4];
#pragma GCC unroll 4
    for (auto& sum : sums) sum = _mm512_set1_epi32(query.offset);
    for (std::size_t step = 0; step < 32; ++step) {
      const __m512i four = Broadcast(query, step);
#pragma GCC unroll 4
      for (std::size_t i = 0; i < 4; ++i) {
        sums[i] =
            _mm512_dpbusd_epi32(sums[i], four, _mm512_load_si512(groups[g + i].steps[step]));
      }
    }
#pragma GCC unroll 4
    for (std::size_t i = 0; i < 4; ++i) {
      _mm512_storeu_si512(dots + (g + i) * kGroupLanes, sums[i]);
    }
  }
  for (; g < groups.size(); ++g) {
    __m512i sum = _mm512_set1_epi32(query.offset);
    for (std::size_t step = 0; step < 32; ++step) {
      sum = _mm512_dpbusd_epi32(sum, Broadcast(query, step),
                                _mm512_load_si512(groups[g].steps[step]));
    }
    _mm512_storeu_si512(dots + g * kGroupLanes, sum);
  }
}

}  // namespace

const GroupKernel kVnniGroupKernel{"AVX-512 VNNI", Meet, Dots};

}  // namespace waymark::localiser::internal

#else

namespace waymark::localiser::internal {

const GroupKernel kVnniGroupKernel{"AVX-512 VNNI", nullptr, nullptr};  // never listed as supported

}  // namespace waymark::localiser::internal

#endif

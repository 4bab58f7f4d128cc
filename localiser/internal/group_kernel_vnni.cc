// SPDX-License-Identifier: Apache-2.0
// No Eigen here: code for wider registers must not share its types (alignment differs).
#include <cstdint>
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

WAYMARK_VNNI inline __m512i Broadcast(const PackedQuery& query, std::size_t step) {
  std::int32_t four;
  std::memcpy(&four, query.descriptor->data() + 4 * step, 4);
  return _mm512_set1_epi32(four);
}

/// Some queries times some groups, an accumulator each, so that loads are shared.
template <std::size_t kQueries, std::size_t kGroups>
WAYMARK_VNNI __attribute__((always_inline)) inline void Multiply(
    const DescriptorGroup* groups, const PackedQuery* queries, __m512i (&dots)[kQueries][kGroups]) {
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueries; ++q) {
#pragma GCC unroll 8
    for (std::size_t g = 0; g < kGroups; ++g) dots[q][g] = _mm512_set1_epi32(queries[q].offset);
  }
  for (std::size_t step = 0; step < 32; ++step) {
    __m512i entries[kGroups];
#pragma GCC unroll 8
    for (std::size_t g = 0; g < kGroups; ++g) {
      entries[g] = _mm512_load_si512(groups[g].steps[step]);
    }
#pragma GCC unroll 8
    for (std::size_t q = 0; q < kQueries; ++q) {
      const __m512i query = Broadcast(queries[q], step);
#pragma GCC unroll 8
      for (std::size_t g = 0; g < kGroups; ++g) {
        dots[q][g] = _mm512_dpbusd_epi32(dots[q][g], query, entries[g]);
      }
    }
  }
}

template <std::size_t kQueries, std::size_t kGroups>
WAYMARK_VNNI void MeetTile(const DescriptorGroup* groups, std::int32_t first_group,
                           std::span<const PackedQuery> queries, const std::uint32_t* chosen,
                           std::span<LaneBest> states) {
  PackedQuery asked[kQueries] = {};
  for (std::size_t q = 0; q < kQueries; ++q) asked[q] = queries[chosen[q]];
  __m512i dots[kQueries][kGroups];
  Multiply(groups, asked, dots);
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueries; ++q) {
    LaneBest& state = states[chosen[q]];
    __m512i first = _mm512_load_si512(state.first_dot);
    __m512i second = _mm512_load_si512(state.second_dot);
    __m512i first_at = _mm512_load_si512(state.first_group);
    __m512i second_at = _mm512_load_si512(state.second_group);
#pragma GCC unroll 8
    for (std::size_t g = 0; g < kGroups; ++g) {
      const __m512i here = dots[q][g];
      const __m512i number = _mm512_set1_epi32(first_group + static_cast<std::int32_t>(g));
      const __mmask16 is_first = _mm512_cmpgt_epi32_mask(here, first);
      const __mmask16 is_second = _mm512_cmpgt_epi32_mask(here, second);
      second = _mm512_max_epi32(second, _mm512_min_epi32(first, here));
      second_at = _mm512_mask_mov_epi32(second_at, is_second, number);
      second_at = _mm512_mask_mov_epi32(second_at, is_first, first_at);
      first = _mm512_max_epi32(first, here);
      first_at = _mm512_mask_mov_epi32(first_at, is_first, number);
    }
    _mm512_store_si512(state.first_dot, first);
    _mm512_store_si512(state.second_dot, second);
    _mm512_store_si512(state.first_group, first_at);
    _mm512_store_si512(state.second_group, second_at);
  }
}

/// Few groups, which stay in the first cache until all have met them.
template <std::size_t kGroups>
void MeetFew(const DescriptorGroup* groups, std::int32_t first_group,
             std::span<const PackedQuery> queries, std::span<const std::uint32_t> chosen,
             std::span<LaneBest> states) {
  for (std::size_t begin = 0; begin < chosen.size(); begin += 4) {
    const auto some = chosen.subspan(begin);
    switch (some.size()) {
      case 1:
        MeetTile<1, kGroups>(groups, first_group, queries, some.data(), states);
        break;
      case 2:
        MeetTile<2, kGroups>(groups, first_group, queries, some.data(), states);
        break;
      case 3:
        MeetTile<3, kGroups>(groups, first_group, queries, some.data(), states);
        break;
      default:
        MeetTile<4, kGroups>(groups, first_group, queries, some.data(), states);
        break;
    }
  }
}

void Meet(std::span<const DescriptorGroup> groups, std::int32_t first_group,
          std::span<const PackedQuery> queries, std::span<const std::uint32_t> chosen,
          std::span<LaneBest> states) {
  for (std::size_t g = 0; g < groups.size(); g += 4) {
    const std::int32_t number = first_group + static_cast<std::int32_t>(g);
    switch (groups.size() - g) {
      case 1:
        MeetFew<1>(&groups[g], number, queries, chosen, states);
        break;
      case 2:
        MeetFew<2>(&groups[g], number, queries, chosen, states);
        break;
      case 3:
        MeetFew<3>(&groups[g], number, queries, chosen, states);
        break;
      default:
        MeetFew<4>(&groups[g], number, queries, chosen, states);
        break;
    }
  }
}

template <std::size_t kQueries, std::size_t kGroups>
WAYMARK_VNNI inline void DotsTile(const DescriptorGroup* groups, const PackedQuery* queries,
                                  std::int32_t* rows, std::size_t row) {
  __m512i dots[kQueries][kGroups];
  Multiply(groups, queries, dots);
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueries; ++q) {
#pragma GCC unroll 8
    for (std::size_t g = 0; g < kGroups; ++g) {
      _mm512_storeu_si512(rows + q * row + g * kGroupLanes, dots[q][g]);
    }
  }
}

template <std::size_t kQueries>
WAYMARK_VNNI void DotsOf(std::span<const DescriptorGroup> groups, const PackedQuery* queries,
                         std::int32_t* dots) {
  const std::size_t row = groups.size() * kGroupLanes;
  std::size_t g = 0;
  for (; g + 4 <= groups.size(); g += 4) {
    DotsTile<kQueries, 4>(&groups[g], queries, dots + g * kGroupLanes, row);
  }
  for (; g < groups.size(); ++g) {
    DotsTile<kQueries, 1>(&groups[g], queries, dots + g * kGroupLanes, row);
  }
}

void Dots(std::span<const DescriptorGroup> groups, std::span<const PackedQuery> queries,
          std::int32_t* dots) {
  const std::size_t row = groups.size() * kGroupLanes;
  std::size_t q = 0;
  for (; q + 4 <= queries.size(); q += 4) DotsOf<4>(groups, &queries[q], dots + q * row);
  for (; q < queries.size(); ++q) DotsOf<1>(groups, &queries[q], dots + q * row);
}

WAYMARK_VNNI std::size_t AtLeast(std::span<const std::int32_t> dots, std::int32_t bound,
                                 std::uint32_t* indices) {
  const __m512i wanted = _mm512_set1_epi32(bound), step = _mm512_set1_epi32(kGroupLanes);
  __m512i here = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
  std::size_t found = 0;
  for (std::size_t begin = 0; begin < dots.size(); begin += kGroupLanes) {
    const std::size_t left = dots.size() - begin;
    const __mmask16 valid = left < kGroupLanes ? static_cast<__mmask16>((1U << left) - 1) : 0xffff;
    const __mmask16 reach =
        _mm512_mask_cmpge_epi32_mask(valid, _mm512_maskz_loadu_epi32(valid, &dots[begin]), wanted);
    _mm512_storeu_si512(indices + found, _mm512_maskz_compress_epi32(reach, here));
    found += static_cast<std::size_t>(__builtin_popcount(reach));
    here = _mm512_add_epi32(here, step);
  }
  return found;
}

}  // namespace

const GroupKernel kVnniGroupKernel{"AVX-512 VNNI", Meet, Dots, AtLeast};

}  // namespace waymark::localiser::internal

#else

namespace waymark::localiser::internal {

const GroupKernel kVnniGroupKernel{"AVX-512 VNNI", nullptr, nullptr,
                                   nullptr};  // never listed as supported

}  // namespace waymark::localiser::internal

#endif

// SPDX-License-Identifier: Apache-2.0
#pragma once

// One vocabulary for registers of 16, 8 and 4 floats; the compiler's flags choose. Each width has
// its own namespace, so that no linker takes one file's inline function for another's.
#include <cstdint>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#if defined(__AVX512VL__)
#define WAYMARK_LANES lanes_avx512
#elif defined(__AVX2__)
#define WAYMARK_LANES lanes_avx2
#else
#define WAYMARK_LANES lanes_portable
#endif

namespace waymark::mapping::internal::WAYMARK_LANES {

#if defined(__AVX512VL__)
constexpr int kLanes = 16;
#elif defined(__AVX2__)
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif

// The compiler's own vector types: + - * / and comparisons work lane by lane.
typedef float Floats __attribute__((vector_size(4 * kLanes)));
typedef std::int32_t Ints __attribute__((vector_size(4 * kLanes)));

#if defined(__AVX512VL__)
using Mask = __mmask16;
#else
using Mask = Ints;  ///< all bits of a lane alike
#endif

inline Floats Set(float value) { return value - Floats{}; }

inline Floats Load(const float* from) {
  Floats value;
  __builtin_memcpy(&value, from, sizeof value);
  return value;
}

inline void Store(float* to, Floats value) { __builtin_memcpy(to, &value, sizeof value); }

inline void Store(std::int32_t* to, Ints value) { __builtin_memcpy(to, &value, sizeof value); }

inline Floats ToFloats(Ints value) { return __builtin_convertvector(value, Floats); }

/// Towards nought.
inline Ints ToInts(Floats value) { return __builtin_convertvector(value, Ints); }

#if defined(__AVX512VL__)

// Some of the plain intrinsics make g++ 12 warn about its own header; masked ones that take all
// lanes compile to the same.
constexpr Mask kAll = 0xFFFF;

inline Mask GreaterEqual(Floats a, Floats b) { return _mm512_cmp_ps_mask(a, b, _CMP_GE_OQ); }
inline Mask And(Mask a, Mask b) { return static_cast<Mask>(a & b); }
inline Mask Or(Mask a, Mask b) { return static_cast<Mask>(a | b); }
inline unsigned Bits(Mask mask) { return mask; }
inline Floats Select(Mask mask, Floats yes, Floats no) {
  return _mm512_mask_blend_ps(mask, no, yes);
}
inline Floats Max(Floats a, Floats b) { return _mm512_maskz_max_ps(kAll, a, b); }
inline Floats Min(Floats a, Floats b) { return _mm512_maskz_min_ps(kAll, a, b); }
inline Floats Abs(Floats a) { return _mm512_abs_ps(a); }
inline Floats Sqrt(Floats a) { return _mm512_maskz_sqrt_ps(kAll, a); }

#elif defined(__AVX2__)

inline Mask GreaterEqual(Floats a, Floats b) { return a >= b; }
inline Mask And(Mask a, Mask b) { return a & b; }
inline Mask Or(Mask a, Mask b) { return a | b; }
inline unsigned Bits(Mask mask) {
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<Floats>(mask)));
}
inline Floats Select(Mask mask, Floats yes, Floats no) {
  return _mm256_blendv_ps(no, yes, reinterpret_cast<Floats>(mask));
}
inline Floats Max(Floats a, Floats b) { return _mm256_max_ps(a, b); }
inline Floats Min(Floats a, Floats b) { return _mm256_min_ps(a, b); }
inline Floats Abs(Floats a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), a); }
inline Floats Sqrt(Floats a) { return _mm256_sqrt_ps(a); }

#else

inline Mask GreaterEqual(Floats a, Floats b) { return a >= b; }
inline Mask And(Mask a, Mask b) { return a & b; }
inline Mask Or(Mask a, Mask b) { return a | b; }
inline unsigned Bits(Mask mask) {
  unsigned bits = 0;
  for (int lane = 0; lane < kLanes; ++lane) bits |= (mask[lane] & 1U) << lane;
  return bits;
}
inline Floats Select(Mask mask, Floats yes, Floats no) {
  return reinterpret_cast<Floats>((reinterpret_cast<Ints>(yes) & mask) |
                                  (reinterpret_cast<Ints>(no) & ~mask));
}
inline Floats Max(Floats a, Floats b) { return Select(a > b, a, b); }
inline Floats Min(Floats a, Floats b) { return Select(a < b, a, b); }
inline Floats Abs(Floats a) {
  return reinterpret_cast<Floats>(reinterpret_cast<Ints>(a) & 0x7fffffff);
}
inline Floats Sqrt(Floats a) {
  for (int lane = 0; lane < kLanes; ++lane) a[lane] = __builtin_sqrtf(a[lane]);
  return a;
}

#endif

/// Neighbouring floats from kLanes places: base[index] and base[index + 1]. Both at once are half
/// the loads of one after the other.
struct Pairs {
  Floats first;
  Floats second;
};

inline Pairs GatherPairs(const float* base, Ints index) {
#if defined(__AVX512VL__)
  __m256i places[2];
  __builtin_memcpy(places, &index, sizeof index);
  const auto pairs = [&](__m256i half) {
    return reinterpret_cast<Floats>(
        _mm512_mask_i32gather_pd(__m512d{}, 0xFF, half, base, sizeof(float)));
  };
  const Floats low = pairs(places[0]), high = pairs(places[1]);
  const Ints even{0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30};
  const auto permute = [&](Ints from) -> Floats {
    return _mm512_permutex2var_ps(low, reinterpret_cast<__m512i>(from), high);
  };
  return {permute(even), permute(even + 1)};
#elif defined(__AVX2__)
  __m128i places[2];
  __builtin_memcpy(places, &index, sizeof index);
  const auto pairs = [&](__m128i half) {
    const auto all = reinterpret_cast<__m256d>(Ints{} == Ints{});
    return reinterpret_cast<Floats>(_mm256_mask_i32gather_pd(
        __m256d{}, reinterpret_cast<const double*>(base), half, all, sizeof(float)));
  };
  const Floats low = pairs(places[0]), high = pairs(places[1]);
  const auto in_order = [](Floats quarters) {
    return reinterpret_cast<Floats>(
        _mm256_permute4x64_pd(reinterpret_cast<__m256d>(quarters), 0b11'01'10'00));
  };
  return {in_order(_mm256_shuffle_ps(low, high, 0b10'00'10'00)),
          in_order(_mm256_shuffle_ps(low, high, 0b11'01'11'01))};
#else
  Pairs pairs;
  for (int lane = 0; lane < kLanes; ++lane) {
    pairs.first[lane] = base[index[lane]];
    pairs.second[lane] = base[index[lane] + 1];
  }
  return pairs;
#endif
}

/// even[0], odd[0], even[1], … : twice kLanes floats.
inline void StoreInterleaved(float* to, Floats even, Floats odd) {
#if defined(__AVX512VL__)
  const Ints low{0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23};
  const auto permute = [&](Ints index) -> Floats {
    return _mm512_permutex2var_ps(even, reinterpret_cast<__m512i>(index), odd);
  };
  Store(to, permute(low));
  Store(to + kLanes, permute(low + 8));
#elif defined(__AVX2__)
  const __m256 low = _mm256_unpacklo_ps(even, odd), high = _mm256_unpackhi_ps(even, odd);
  Store(to, _mm256_permute2f128_ps(low, high, 0x20));
  Store(to + kLanes, _mm256_permute2f128_ps(low, high, 0x31));
#else
  for (int lane = 0; lane < kLanes; ++lane) {
    to[2 * lane] = even[lane];
    to[2 * lane + 1] = odd[lane];
  }
#endif
}

/// Eight floats whatever the width of a register: sums over eight lanes have one order everywhere.
struct Eight {
#if defined(__AVX2__)
  static constexpr int kParts = 1;
  typedef float Part __attribute__((vector_size(32)));
#else
  static constexpr int kParts = 2;
  typedef float Part __attribute__((vector_size(16)));
#endif
  Part parts[kParts];

  static Eight From(const float* from) {
    Eight value;
    __builtin_memcpy(&value, from, sizeof value);
    return value;
  }
  void To(float* to) const { __builtin_memcpy(to, this, sizeof *this); }

  friend Eight operator+(Eight a, const Eight& b) {
    for (int p = 0; p < kParts; ++p) a.parts[p] += b.parts[p];
    return a;
  }
  friend Eight operator-(Eight a, const Eight& b) {
    for (int p = 0; p < kParts; ++p) a.parts[p] -= b.parts[p];
    return a;
  }
  friend Eight operator*(Eight a, float b) {
    for (int p = 0; p < kParts; ++p) a.parts[p] *= b;
    return a;
  }
};

}  // namespace waymark::mapping::internal::WAYMARK_LANES

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace waymark::mapping {

/// A generator whose stream depends on the seed and the subset alone.
inline std::mt19937_64 SubsetRandom(std::uint64_t seed, std::uint64_t subset) {
  return std::mt19937_64(seed * 0x9E3779B97F4A7C15u + subset);
}

/// A random choice of `count` values, ascending; all of them when there are no more. Written out
/// because std::shuffle differs between standard libraries.
std::vector<std::uint32_t> SampleValues(std::vector<std::uint32_t> values, std::size_t count,
                                        std::mt19937_64& random);

}  // namespace waymark::mapping

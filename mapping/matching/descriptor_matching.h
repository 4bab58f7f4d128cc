// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mapping/features/features.h"

namespace waymark::mapping {

/// The two most similar database entries of one query, by dot product of the 8-bit descriptors.
struct NearestTwo {
  std::uint32_t first = std::numeric_limits<std::uint32_t>::max();  ///< max: the database was empty
  std::int32_t first_dot = -1;
  std::int32_t second_dot = -1;
};

/// Exhaustive search with the widest integer dot product that this processor has (AVX-512 VNNI,
/// AVX2 or portable); all give identical results. Shapes: one answer per query; ties go to the
/// lower index. Single-threaded.
std::vector<NearestTwo> FindNearestTwo(std::span<const Descriptor> queries,
                                       std::span<const Descriptor> database);

/// Of a descriptor, whose values are 512 times those of a unit vector.
inline constexpr double kSquaredDescriptorLength = 512.0 * 512.0;

/// The angle in radians between two descriptors of this dot product, taken as unit vectors.
double DescriptorAngle(std::int32_t dot);

struct MatchOptions {
  double max_ratio = 0.8;      ///< angle to the best over angle to the second best, (0, 1]
  double max_angle_rad = 0.7;  ///< COLMAP's default
  bool mutual = true;          ///< keep only pairs that choose each other

  Result<void> Validate() const;
};

struct FeatureMatch {
  std::uint32_t first;  ///< index in the first image's features
  std::uint32_t second;

  friend auto operator<=>(const FeatureMatch&, const FeatureMatch&) = default;
};

/// Matches two images' descriptors; sorted by `first`.
std::vector<FeatureMatch> MatchDescriptors(std::span<const Descriptor> first,
                                           std::span<const Descriptor> second,
                                           const MatchOptions& options);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/descriptor_matching.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mapping/matching/internal/nearest_two_kernels.h"
#include "mapping/matching/internal/ratio_test.h"

namespace waymark::mapping {
namespace {

using internal::Choose;

/// Keeps the matches whose second descriptor chooses the first in turn. Only descriptors that were
/// chosen are asked: usually a fraction of the image.
void KeepMutual(std::span<const Descriptor> first, std::span<const Descriptor> second,
                const MatchOptions& options, std::vector<FeatureMatch>& matches) {
  std::vector<Descriptor> chosen;
  chosen.reserve(matches.size());
  for (const FeatureMatch& match : matches) chosen.push_back(second[match.second]);
  const std::vector<NearestTwo> nearest = FindNearestTwo(chosen, first);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (Choose(nearest[i], options) == matches[i].first) matches[kept++] = matches[i];
  }
  matches.resize(kept);
}

}  // namespace

std::vector<NearestTwo> FindNearestTwo(std::span<const Descriptor> queries,
                                       std::span<const Descriptor> database) {
  return internal::FindNearestTwo(internal::SupportedNearestTwoKernels().front(), queries,
                                  database);
}

double DescriptorAngle(std::int32_t dot) {
  return std::acos(std::clamp(dot / kSquaredDescriptorLength, -1.0, 1.0));
}

Result<void> MatchOptions::Validate() const {
  if (!(max_ratio > 0 && max_ratio <= 1)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "max_ratio: expected a number in (0, 1], found {}", max_ratio);
  }
  if (!(max_angle_rad > 0 && max_angle_rad <= std::numbers::pi)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "max_angle_rad: expected a number in (0, pi], found {}", max_angle_rad);
  }
  return {};
}

std::vector<FeatureMatch> MatchDescriptors(std::span<const Descriptor> first,
                                           std::span<const Descriptor> second,
                                           const MatchOptions& options) {
  const std::vector<NearestTwo> nearest = FindNearestTwo(first, second);
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    if (const auto chosen = Choose(nearest[i], options)) {
      matches.push_back({.first = static_cast<std::uint32_t>(i), .second = *chosen});
    }
  }
  if (options.mutual) KeepMutual(first, second, options, matches);
  return matches;
}

}  // namespace waymark::mapping

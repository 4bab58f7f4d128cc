// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/representatives.h"

#include <algorithm>
#include <numbers>
#include <numeric>

#include "mapping/base/check.h"
#include "mapping/matching/descriptor_matching.h"

namespace waymark::mapping {
namespace {

/// All angles between descriptors, row by row.
std::vector<double> FindAngles(std::span<const Descriptor> descriptors) {
  const std::size_t count = descriptors.size();
  std::vector<double> angles_rad(count * count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Descriptor& a = descriptors[i];
      angles_rad[i * count + j] = angles_rad[j * count + i] = DescriptorAngle(
          std::inner_product(a.begin(), a.end(), descriptors[j].begin(), 0));
    }
  }
  return angles_rad;
}

}  // namespace

std::vector<std::uint32_t> ChooseRepresentatives(std::span<const Descriptor> descriptors,
                                                 const RepresentativeOptions& options) {
  CHECK(!descriptors.empty() && options.max_count >= 1);
  const std::size_t count = descriptors.size();
  if (count == 1) return {0};
  const std::vector<double> angles_rad = FindAngles(descriptors);
  std::vector<double> nearest_rad(count, std::numbers::pi / 2);  // to a chosen one
  std::vector<std::uint32_t> chosen;
  while (chosen.size() < std::min(options.max_count, count)) {
    double best_gain_rad = -1;
    std::size_t best = 0;
    for (std::size_t candidate = 0; candidate < count; ++candidate) {
      const double* const from = &angles_rad[candidate * count];
      double gain_rad = 0;
      for (std::size_t i = 0; i < count; ++i) gain_rad += std::max(0.0, nearest_rad[i] - from[i]);
      if (gain_rad <= best_gain_rad) continue;
      best_gain_rad = gain_rad;
      best = candidate;
    }
    const double mean_gain_rad = best_gain_rad / static_cast<double>(count);
    if (!chosen.empty() && mean_gain_rad < options.min_gain_rad) break;
    chosen.push_back(static_cast<std::uint32_t>(best));
    for (std::size_t i = 0; i < count; ++i) {
      nearest_rad[i] = std::min(nearest_rad[i], angles_rad[best * count + i]);
    }
  }
  return chosen;
}

}  // namespace waymark::mapping

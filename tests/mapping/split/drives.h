// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "mapping/split/split.h"

namespace waymark::mapping {

inline SplitImage At(double seconds, double east_m, double north_m) {
  return {FromNanoseconds<SensorTime>(static_cast<std::int64_t>(seconds * 1e9)),
          Point<Map>(east_m, north_m, 0)};
}

inline std::vector<SplitImage> Street(double length_m, double step_m) {
  std::vector<SplitImage> images;
  for (int i = 0; i * step_m <= length_m; ++i)
    images.push_back(At(i, 0.6 * i * step_m, 0.8 * i * step_m));
  return images;
}

/// A drive that turns at random and may cross itself.
inline std::vector<SplitImage> Wander(int count, double step_m, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> turn(0, 0.15);
  std::vector<SplitImage> images;
  double heading = 0, east_m = 0, north_m = 0;
  for (int i = 0; i < count; ++i) {
    heading += turn(random);
    east_m += step_m * std::cos(heading);
    north_m += step_m * std::sin(heading);
    images.push_back(At(i, east_m, north_m));
    if (i % 17 == 3) images.back().position.reset();
  }
  return images;
}

/// Every subset with every image.
inline std::string Describe(const Split& split) {
  std::string text;
  for (const ImageSubset& subset : split.subsets) {
    for (const auto* list : {&subset.owned, &subset.neighbour, &subset.foreign}) {
      for (const std::uint32_t i : *list) text += std::to_string(i) + " ";
      text += "|";
    }
  }
  return text;
}

}  // namespace waymark::mapping

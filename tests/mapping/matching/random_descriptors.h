// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "mapping/features/features.h"

namespace waymark::mapping {

/// Any bytes: what a file may hold.
inline std::vector<Descriptor> RandomBytes(std::size_t count, std::mt19937& random) {
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (std::uint8_t& value : descriptor) value = static_cast<std::uint8_t>(random());
  }
  return descriptors;
}

using Histogram = std::array<double, std::tuple_size_v<Descriptor>>;

/// Scaled to length 512 and rounded, as features are.
inline Descriptor Quantised(const Histogram& roots) {
  double sum = 0;
  for (const double value : roots) sum += value * value;
  Descriptor descriptor;
  std::ranges::transform(roots, descriptor.begin(), [&](double value) {
    return static_cast<std::uint8_t>(std::min(255.0, std::round(512 * value / std::sqrt(sum))));
  });
  return descriptor;
}

/// Unit vectors with the uneven histograms of real features.
inline std::vector<Descriptor> RandomRootSift(std::size_t count, std::mt19937& random) {
  std::exponential_distribution<double> bin;
  std::vector<Descriptor> descriptors;
  for (std::size_t i = 0; i < count; ++i) {
    Histogram roots;
    for (double& value : roots) value = bin(random);
    descriptors.push_back(Quantised(roots));
  }
  return descriptors;
}

/// The descriptor with noise on each component, again a unit vector.
inline Descriptor Disturbed(const Descriptor& descriptor, double sigma, std::mt19937& random) {
  std::normal_distribution<double> noise(0, sigma);
  Histogram roots;
  std::ranges::transform(descriptor, roots.begin(),
                         [&](double value) { return std::max(0.0, value + noise(random)); });
  return Quantised(roots);
}

}  // namespace waymark::mapping

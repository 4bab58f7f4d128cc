// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include "mapping/store/release.h"
#include "tests/support/random_geometry.h"

namespace waymark::mapping {

/// A release of three submaps that exist nowhere.
inline Release ExampleRelease(std::uint64_t epoch = 3, std::uint64_t seed = 1) {
  support::RandomGeometry random(seed);
  Release release;
  release.epoch = epoch;
  if (epoch > 1) release.parent_epoch = epoch - 1;
  release.created_utc = "2024-05-01T12:00:00Z";
  for (int i = 0; i < 3; ++i) {
    ReleasedSubmap submap{SubmapId(fmt::format("{:032x}", 0xab0 + i)),
                          Similarity<Map, Submap>(random.Similarity()),
                          Point<Map>(random.Vector(1000)),
                          random.Uniform(0, 100),
                          random.Uniform(0, 1),
                          random.Uniform(0, 5),
                          std::nullopt};
    if (i > 0) submap.displacement = Displacement{0.1 / 3, 1e-5, 1.0000001};
    release.submaps.push_back(submap);
  }
  return release;
}

}  // namespace waymark::mapping

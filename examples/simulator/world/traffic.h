// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/world/city.h"

namespace waymark::simulator {

/// How much stands about that will be gone tomorrow.
struct TrafficOptions {
  double parked_share = 0.35;   ///< of the parking places along the kerbs, [0, 1]
  double people_per_100_m = 8;  ///< standing near the kerbs, per 100 m of street, [0, 1000]

  Result<void> Validate() const;
};

/// Parked cars and bystanders of one recording: another seed, another street scene. They stay clear
/// of the middle of the road and of the half of each pavement that is next to the houses.
Mesh MakeTraffic(const City& city, const TrafficOptions& options, Random random);

}  // namespace waymark::simulator

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/base/result.h"

namespace waymark::bench {

struct SwapOptions {
  std::vector<int> anchors;  ///< of the room, each a measurement
  double city_m = 3000;      ///< edge of the square that they stand in
  double anchor_radius_m = 100;
  int phones = 100;  ///< that walk in the city
  int swaps = 3;     ///< of each measurement, one after the other; the worst counts
};

/// Releases go live under a room: how long the server's loop was away for it, and what a room of so
/// many anchors takes. Prints a table. Errors: those of a crowd.
Result<void> MeasureSwaps(const SwapOptions& options);

}  // namespace waymark::bench

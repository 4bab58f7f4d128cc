// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/motion/motion.h"
#include "examples/simulator/motion/route.h"
#include "examples/simulator/random.h"
#include "examples/simulator/world/city.h"

namespace waymark::simulator {

/// Who moves through which time: motions are defined on [0, duration].
struct Travel {
  Motion motion;
  double duration_s;
};

/// A car on the road around the first block.
struct DriveOptions {
  double length_m = 55;  ///< [5, 5000]; from before the block's first corner to behind it
  double speed_mps = 5;  ///< [0.5, 20]

  Result<void> Validate() const;
};

/// Somebody with a phone on a pavement along the same stretch.
struct WalkOptions {
  double duration_s = 40;  ///< [1, 3600]
  double speed_mps = 1.1;  ///< [0.1, 3]; slow: they look at the houses

  Result<void> Validate() const;
};

/// Which side of the street one walks on.
enum class Pavement { kInner, kOuter };

/// Where the car's path lies; every seed keeps another distance from the kerb.
Travel MakeDrive(const City& city, const DriveOptions& options, Random random);

/// A walk inside the stretch of the drive, the same way or against it.
Travel MakeWalk(const City& city, const DriveOptions& drive, const WalkOptions& options,
                Pavement pavement, Turning turning, Random random);

}  // namespace waymark::simulator

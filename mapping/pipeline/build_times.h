// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::mapping {

/// What building one submap took, by the clock on the wall.
struct BuildTimes {
  double matching_s = 0;  ///< with reading the features
  double reconstruction_s = 0;
  double verification_s = 0;  ///< with pruning, assembly and storing
  int matching_threads = 0;   ///< the others have one; 0: nobody took the time
};

/// What taking an experience into a map took, over all runs that came to the end of the stage.
struct IndexTimes {
  double features_s = 0;
  double split_s = 0;
  int features_threads = 0;  ///< of the last run
};

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::bench {

/// What an app sees that links the device library, beside a crowd that walks meanwhile.
struct AppTimes {
  /// Until it holds all anchors around it and knows where the others are.
  std::vector<float> joins_ms;
  std::size_t anchors_held = 0;  ///< then
  std::vector<float> anchors_ms,
      asked_ms;  ///< from the acknowledgement until another phone has the anchor
};

struct AppOptions {
  std::string server;
  int domain = 0;
  std::string room;
  int others = 0;              ///< that walk in the room
  int joins = 0;               ///< one after the other
  int anchors = 0;             ///< that one phone places while another watches
  double anchor_radius_m = 0;  ///< in which an app wants to know of anchors
};

/// Apps that stand in the middle of the map. Errors: those of a DeviceSession; Timeout.
Result<AppTimes> MeasureApps(const AppOptions& options);

}  // namespace waymark::bench

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::bench {

/// What an app sees that links the device library, beside a crowd that walks meanwhile.
struct AppTimes {
  std::vector<float> joins_ms;    ///< until it holds all anchors and knows where `others` are
  std::vector<float> anchors_ms;  ///< from the acknowledgement until another phone has the anchor
};

/// Joins the room so many times, then lets one phone place so many anchors and another watch.
/// Errors: those of a DeviceSession; Timeout.
Result<AppTimes> MeasureApps(const std::string& server, int domain, const std::string& room,
                             int others, int joins, int anchors);

}  // namespace waymark::bench

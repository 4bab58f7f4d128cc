// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/base/result.h"

namespace waymark::bench {

/// What devices on the bus cost the network before anybody says where it is: each is a participant
/// that knows the server alone. They come 50 to a room, the bus is cut into so many slices. Counts
/// all that goes over the loopback interface, so nothing else should: run it in a network namespace
/// of its own. Errors: those of BusCrowd; NotFound
/// (/proc/net/dev).
Result<void> MeasureDiscovery(const std::vector<int>& devices, int slices);

}  // namespace waymark::bench

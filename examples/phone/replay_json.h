// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "examples/phone/replay.h"

namespace waymark::phone {

/// The outcome of a walk as JSON, for reports. Poses are [tx, ty, tz, qx, qy, qz, qw].
///   {"name", "device", "walk", "statistics": {...},
///    "track": [{"image", "seconds", "state", "fix_source", "epoch", "map_from_camera" | null,
///               "others", "oldest_other_s",
///               "apart_p50_m", "apart_p95_m" where expected}],
///    "placed": id | null, "place_error": "…",
///    "anchors": [{"id", "owner", "kind", "payload", "revision", "epoch", "map_from_anchor",
///                 "first_seen_s"}]}
std::string EncodeReplay(const Replay& replay, const Walk& walk, const std::string& name,
                         const DeviceId& device, const session::DeviceStatistics& statistics);

}  // namespace waymark::phone

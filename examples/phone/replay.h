// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "examples/phone/walk.h"
#include "mapping/base/result.h"
#include "session/device/agreement.h"

namespace waymark::phone {

/// What the phone believed when it took a frame, before the server could answer for that frame.
struct TrackPoint {
  std::string image;
  double seconds = 0;  ///< since the walk began
  session::DevicePose pose;
  int others_present = 0;
  double oldest_other_s = 0;  ///< age of the stalest pose of a present phone
  /// How far from it others show the anchors that they and it look at, as far as poses tell:
  /// medians over these.
  std::optional<session::ExpectedDistance> apart = std::nullopt;
};

/// An anchor when this phone first knew it.
struct AnchorSighting {
  AnchorId id;
  double first_seen_s = 0;
};

struct ReplayOptions {
  double place_anchor_after_s = -1;  ///< seconds into the walk; negative: never
  std::string anchor_kind = "note";
  content::AnchorVisibility audience = content::AnchorVisibility::kRoom;
  Transform<Device, Anchor> device_from_anchor;  ///< where the anchor goes, seen from the phone
};

struct Replay {
  std::vector<TrackPoint> track;
  std::vector<AnchorSighting> sightings;
  std::vector<session::SharedAnchor> anchors;  ///< as known when the walk ended
  std::optional<AnchorId> placed;
  std::string place_error;  ///< the last refusal while trying to place, if it never worked
};

/// Walks through a recording at its own pace as a phone app would: odometry at its rate, frames
/// when taken, the anchor once the phone knows where it is. Stops early when `stop` turns true.
/// Errors: an image that cannot be read or decoded.
Result<Replay> ReplayWalk(const Walk& walk, session::DeviceSession& device,
                          const ReplayOptions& options, const std::atomic<bool>& stop);

}  // namespace waymark::phone

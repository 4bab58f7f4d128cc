// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/geometry/frames.h"

namespace waymark::demo {

/// What one phone believed at one frame of its walk.
struct BelievedPose {
  std::string image;
  double seconds = 0;
  std::string state;
  std::optional<Transform<Map, Camera>> map_from_camera;
  int others_present = 0;
  double oldest_other_s = 0;
};

struct KnownAnchor {
  std::string id;
  Transform<Map, Anchor> map_from_anchor;
  std::optional<double> first_seen_s;
};

/// The file that waymark-phone leaves; see examples/phone/replay_json.h.
struct PhoneResult {
  std::string name;
  int keyframes_sent = 0;
  int fixes = 0;
  int refusals = 0;
  int timeouts = 0;
  std::vector<double> fix_latency_ms;
  std::vector<BelievedPose> track;
  std::optional<std::string> placed;
  std::string place_error;
  std::vector<KnownAnchor> anchors;
};

/// Errors: NotFound; Corrupt when the file is not what waymark-phone writes.
Result<PhoneResult> LoadPhoneResult(const std::filesystem::path& file);

}  // namespace waymark::demo

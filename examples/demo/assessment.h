// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "examples/demo/map_truth.h"
#include "examples/demo/phone_result.h"
#include "examples/demo/truth.h"

namespace waymark::demo {

/// A phone and what really happened to it.
struct WalkedPhone {
  PhoneResult result;
  TruePoses truth;
};

/// How well one phone knew where it was, over all frames at which it claimed to know.
struct PhoneFigures {
  std::string name;
  int frames = 0;
  int frames_with_pose = 0;
  double first_fix_s = 0;     ///< when it first knew
  double median_error_m = 0;  ///< position in the map, after the map's rigid fit to truth
  double p90_error_m = 0;
  double max_error_m = 0;
  double median_error_deg = 0;
  double median_geodetic_error_m = 0;  ///< position on the earth: includes the map's GNSS error
  double median_latency_ms = 0;
  double p90_latency_ms = 0;
  int most_others = 0;  ///< phones seen at once
};

/// Where one phone shows an anchor: in the true world, through its own believed pose.
struct AnchorView {
  std::string phone;
  bool is_known = false;                          ///< the phone has received the anchor
  std::optional<Eigen::Vector3d> shown_in_world;  ///< absent if it never had a pose
  std::optional<double> first_seen_s;
  double from_placed_cm = 0;  ///< distance from where its owner saw it when placing
};

struct AnchorFigures {
  std::string id;
  std::string owner;
  std::vector<AnchorView> views;
  double spread_cm = 0;  ///< largest distance between two phones' views
  /// Distance between where two phones show it, frame by frame: over every pair of phones and the
  /// last frames of both.
  double agreement_p50_cm = 0, agreement_p95_cm = 0;
  int agreement_pairs = 0;  ///< of frames
};

PhoneFigures AssessPhone(const WalkedPhone& phone, const MapAlignment& alignment);

/// One anchor through every phone. A phone shows it at
/// world_from_camera(true) * camera_from_map(believed) * map_from_anchor, taken as the median over
/// its last frames, so that one frame's odometry noise is not the answer.
std::vector<AnchorFigures> AssessAnchors(const std::vector<WalkedPhone>& phones);

}  // namespace waymark::demo

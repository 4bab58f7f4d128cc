// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "localiser/localiser.h"
#include "session/device/device_session.h"
#include "tests/evaluation/localisation/judging.h"

namespace waymark::evaluation {

/// Walkers with phones in a mapped street: what is mapped, how wrong the map is, how slow the
/// network.
struct PhonePlan {
  simulator::CityOptions city;
  simulator::CarOptions car;
  simulator::PhoneOptions phone;
  simulator::LightPreset drive = simulator::LightPreset::kDay;
  simulator::LightPreset light = simulator::LightPreset::kOvercast;  ///< of the walks
  std::size_t submap_pictures = 48;             ///< of the drive's; neighbours share a third
  double placement_sigma_m = 0.05;              ///< per axis: how wrong fusion leaves each submap
  Angle placement_sigma = Angle::Degrees(0.1);  ///< likewise, about the vertical
  int walkers = 4;
  double keyframe_interval_s = 1;
  double latency_s = 0.5;  ///< from an image until its fix is applied
  PhoneSenses senses;
  localiser::AlignmentOptions alignment;
  session::CorrectionOptions correction;
  std::uint64_t seed = 1;
};

/// Shrinks the plan to what a test can afford: the simulator's tiny world.
void MakeQuick(PhonePlan& plan);

/// What a phone showed at one instant, beside the truth.
struct ShownInstant {
  double time_s = 0;
  Rigid3 map_from_device;  ///< truth
  Rigid3 vo_from_device;   ///< the phone's odometry
  localiser::AlignmentState state{};
  std::optional<Rigid3> shown;          ///< what content is drawn with
  session::PoseCertainty certainty;     ///< of that, as the phone says
  std::optional<Rigid3> by_newest_fix;  ///< odometry chained to the newest fix alone
  double update_ms = 0;                 ///< processor time of the phone's own part
};

/// An answer to a keyframe.
struct JudgedFix {
  double time_s = 0;                ///< when its image was taken
  Rigid3 map_from_device;           ///< truth
  Rigid3 localised_from_device;     ///< the answer
  double map_error_m = 0;           ///< how far the map has moved that place
  double localisation_error_m = 0;  ///< against the map as it is
};

/// One walk.
struct PhoneTrial {
  int requests = 0;
  std::vector<ShownInstant> shown;         ///< by time, at the rate of the odometry
  std::vector<JudgedFix> fixes;            ///< by time
  std::vector<Eigen::Vector3d> satellite;  ///< the receiver's fixes in the map
  std::vector<double> satellite_errors_m;  ///< of these, horizontally
};

/// Draws, maps and walks; what the workshop holds already is not done again. The phones run the
/// device library's own tracker on the answers of the localiser. Deterministic.
Result<std::vector<PhoneTrial>> RunPhones(const PhonePlan& plan, const Workshop& workshop);

}  // namespace waymark::evaluation

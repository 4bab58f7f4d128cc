// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mapping/store/release.h"
#include "tests/evaluation/localisation/judging.h"

namespace waymark::evaluation {

/// What is mapped, step by step, and under which lights phones ask.
struct ConditionsPlan {
  simulator::CityOptions city;
  simulator::CarOptions car;
  simulator::PhoneOptions phone;
  int keyframes_per_walk = 36;
  int requests = 1008;    ///< of every row, spread evenly over the lights
  std::size_t burst = 1;  ///< keyframes that are asked as one; 1: each by itself
  double summary_mb = 0;  ///< submaps are summaries of so many 10^6 bytes; 0: whole
  PhoneSenses senses;
  /// The drives in the order in which they join the map; a row of the table is the first so many.
  std::vector<simulator::LightPreset> drives{
      simulator::LightPreset::kDay,     simulator::LightPreset::kOvercast,
      simulator::LightPreset::kDay,     simulator::LightPreset::kLowSunBehind,
      simulator::LightPreset::kEvening, simulator::LightPreset::kNight,
      simulator::LightPreset::kRain};
  std::vector<std::size_t> rows{1, 4, 6, 7};
  std::vector<simulator::LightPreset> lights{
      simulator::LightPreset::kDay,          simulator::LightPreset::kOvercast,
      simulator::LightPreset::kRain,         simulator::LightPreset::kEvening,
      simulator::LightPreset::kNight,        simulator::LightPreset::kLowSunBehind,
      simulator::LightPreset::kLowSunAgainst};
  std::uint64_t seed = 1;
};

/// Shrinks the plan to what a test can afford: the simulator's tiny world.
void MakeQuick(ConditionsPlan& plan);

/// The plan's drives as submaps, one each, in their order; drawn and mapped where the workshop does
/// not hold them yet.
Result<std::vector<mapping::ReleasedSubmap>> MapDrives(const ConditionsPlan& plan,
                                                       const Workshop& workshop);

/// What phones ask, beside the pictures that it was taken from.
struct AskedPictures {
  std::vector<Question> questions;  ///< with features
  std::vector<TruePicture> pictures;
  std::vector<std::size_t> walk_begins;  ///< of each, the first of its walk
};

/// As many as the plan says, light after light.
Result<AskedPictures> DrawQuestions(const ConditionsPlan& plan, const Workshop& workshop);

/// One row of the table.
struct ConditionsRow {
  std::vector<simulator::LightPreset> drives;
  std::vector<Verdict> verdicts;
  std::size_t landmarks_bytes = 0;  ///< of submap files
  double resident_mib = 0;          ///< that opening the release added to the process
  double opening_s = 0;
  /// Median of requests with pixels, one in sixteen: features and all.
  double request_ms = 0;
  double features_ms = 0;
};

/// Draws, maps and asks; what the workshop holds already is not done again. `report` is called with
/// every row as soon as it is known, and may be empty.
Result<std::vector<ConditionsRow>> RunConditions(
    const ConditionsPlan& plan, const Workshop& workshop,
    const std::function<void(const ConditionsRow&)>& report = {});

/// What a row cost and how well its covariances describe its errors, two lines.
std::string DescribeRow(const ConditionsRow& row);
/// Each refused request: its number in the row, its light and the localiser's reason.
std::string DescribeRefusals(const ConditionsRow& row);
/// The table of rates as text, and everything as one JSON document.
std::string DescribeConditions(const ConditionsPlan& plan, const std::vector<ConditionsRow>& rows);
std::string EncodeConditions(const ConditionsPlan& plan, const std::vector<ConditionsRow>& rows);

}  // namespace waymark::evaluation

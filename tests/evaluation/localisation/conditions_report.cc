// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tests/evaluation/localisation/conditions.h"

namespace waymark::evaluation {
namespace {

std::string DriveNames(const ConditionsRow& row) {
  std::string names;
  for (const auto light : row.drives) {
    if (!names.empty()) names += " + ";
    names += simulator::LightPresetName(light);
  }
  return names;
}

std::string RecallCell(const Recall& recall) {
  return fmt::format("{:5.1f} {:5.1f} {:5.1f} {:5.1f}", 100 * recall.Share(recall.accepted),
                     100 * recall.Share(recall.within_10cm_1deg),
                     100 * recall.Share(recall.within_25cm_2deg),
                     100 * recall.Share(recall.within_1m_5deg));
}

nlohmann::ordered_json ToJson(const Recall& recall) {
  return {{"requests", recall.requests},
          {"localised", recall.accepted},
          {"within_0.1m_1deg", recall.within_10cm_1deg},
          {"within_0.25m_2deg", recall.within_25cm_2deg},
          {"within_1m_5deg", recall.within_1m_5deg},
          {"false", recall.false_poses}};
}

}  // namespace

std::string DescribeRow(const ConditionsRow& row) {
  const Recall all = Count(row.verdicts);
  const Calibration calibration = Calibrate(row.verdicts);
  return fmt::format(
      "{}: {}\n   {} requests, {} false poses; {:.0f} MiB of submaps, {:.0f} MiB resident, opened "
      "in {:.1f} s; {:.0f} ms a request, {:.0f} of it for features\n   inside the 95 % ellipsoid: "
      "position {:.1f} %, rotation {:.1f} %, both {:.1f} %; for 95 % multiply sigmas by {:.2f} and "
      "{:.2f}\n",
      row.drives.size(), DriveNames(row), all.requests, all.false_poses,
      static_cast<double>(row.landmarks_bytes) / (1 << 20), row.resident_mib, row.opening_s,
      row.request_ms, row.features_ms, 100 * calibration.position_inside,
      100 * calibration.rotation_inside, 100 * calibration.pose_inside, calibration.position_factor,
      calibration.rotation_factor);
}

std::string DescribeRefusals(const ConditionsRow& row) {
  std::string text;
  for (std::size_t i = 0; i < row.verdicts.size(); ++i) {
    const Verdict& verdict = row.verdicts[i];
    if (!verdict.is_accepted) text += fmt::format("  {} {}: {}\n", i, verdict.kind, verdict.reason);
  }
  return text;
}

std::string DescribeConditions(const ConditionsPlan& plan, const std::vector<ConditionsRow>& rows) {
  std::string text =
      "\nSimulation: pictures of waymark-simulate's city; submaps triangulated with the true poses "
      "of\n"
      "their images, one per drive. Per cent of requests localised | within 0.1 m and 1 deg | 0.25 "
      "m\n"
      "and 2 deg | 1 m and 5 deg of the truth.\n\n";
  text += fmt::format("{:18}", "drives in the map");
  for (const ConditionsRow& row : rows) text += fmt::format(" | {:23}", row.drives.size());
  text += "\n";
  for (const auto light : plan.lights) {
    const std::string kind(simulator::LightPresetName(light));
    text += fmt::format("{:18}", kind);
    for (const ConditionsRow& row : rows) text += " | " + RecallCell(Count(row.verdicts, kind));
    text += "\n";
  }
  text += fmt::format("{:18}", "all");
  for (const ConditionsRow& row : rows) text += " | " + RecallCell(Count(row.verdicts));
  text += "\n";
  return text;
}

std::string EncodeConditions(const ConditionsPlan& plan, const std::vector<ConditionsRow>& rows) {
  nlohmann::ordered_json json;
  json["maps"] = "simulation; triangulated with true poses";
  for (const ConditionsRow& row : rows) {
    nlohmann::ordered_json entry;
    for (const auto light : row.drives)
      entry["drives"].push_back(simulator::LightPresetName(light));
    entry["all"] = ToJson(Count(row.verdicts));
    for (const auto light : plan.lights) {
      const std::string kind(simulator::LightPresetName(light));
      entry["by_light"][kind] = ToJson(Count(row.verdicts, kind));
    }
    const Calibration calibration = Calibrate(row.verdicts);
    entry["covariance"] = {{"poses", calibration.poses},
                           {"position_inside_95", calibration.position_inside},
                           {"rotation_inside_95", calibration.rotation_inside},
                           {"pose_inside_95", calibration.pose_inside},
                           {"position_sigma_factor", calibration.position_factor},
                           {"rotation_sigma_factor", calibration.rotation_factor}};
    entry["submap_bytes"] = row.landmarks_bytes;
    entry["resident_mib"] = row.resident_mib;
    entry["opening_s"] = row.opening_s;
    entry["request_ms"] = row.request_ms;
    entry["features_ms"] = row.features_ms;
    json["rows"].push_back(std::move(entry));
  }
  return json.dump(2) + "\n";
}

}  // namespace waymark::evaluation

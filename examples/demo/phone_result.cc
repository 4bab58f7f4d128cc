// SPDX-License-Identifier: Apache-2.0
#include "examples/demo/phone_result.h"

#include <nlohmann/json.hpp>

#include "mapping/base/file.h"

namespace waymark::demo {
namespace {

using Json = nlohmann::json;

Rigid3 ParsePose(const Json& json) {
  const auto v = json.get<std::vector<double>>();
  return {Eigen::Quaterniond(v.at(6), v.at(3), v.at(4), v.at(5)),
          Eigen::Vector3d(v.at(0), v.at(1), v.at(2))};
}

BelievedPose ParseBelievedPose(const Json& json) {
  BelievedPose pose{.image = json.at("image"),
                    .seconds = json.at("seconds"),
                    .state = json.at("state"),
                    .map_from_camera = std::nullopt,
                    .others_present = json.at("others"),
                    .oldest_other_s = json.at("oldest_other_s")};
  if (!json.at("map_from_camera").is_null()) {
    pose.map_from_camera = Transform<Map, Camera>(ParsePose(json.at("map_from_camera")));
  }
  return pose;
}

KnownAnchor ParseAnchor(const Json& json) {
  KnownAnchor anchor{
      .id = json.at("id"),
      .map_from_anchor = Transform<Map, Anchor>(ParsePose(json.at("map_from_anchor"))),
      .first_seen_s = std::nullopt};
  if (!json.at("first_seen_s").is_null()) anchor.first_seen_s = json.at("first_seen_s");
  return anchor;
}

PhoneResult ParsePhoneResult(const Json& json) {
  const Json& statistics = json.at("statistics");
  PhoneResult result{.name = json.at("name"),
                     .keyframes_sent = statistics.at("keyframes_sent"),
                     .fixes = statistics.at("fixes"),
                     .refusals = statistics.at("refusals"),
                     .timeouts = statistics.at("timeouts"),
                     .fix_latency_ms = statistics.at("fix_latency_ms"),
                     .track = {},
                     .placed = std::nullopt,
                     .place_error = json.at("place_error"),
                     .anchors = {}};
  for (const Json& point : json.at("track")) result.track.push_back(ParseBelievedPose(point));
  for (const Json& anchor : json.at("anchors")) result.anchors.push_back(ParseAnchor(anchor));
  if (!json.at("placed").is_null()) result.placed = json.at("placed");
  return result;
}

}  // namespace

Result<PhoneResult> LoadPhoneResult(const std::filesystem::path& file) {
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(file));
  try {
    return ParsePhoneResult(Json::parse(text));
  } catch (const std::exception& exception) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected what waymark-phone writes, found: {}",
                     file.string(), exception.what());
  }
}

}  // namespace waymark::demo

// SPDX-License-Identifier: Apache-2.0
#include "examples/phone/replay_json.h"

#include <nlohmann/json.hpp>

namespace waymark::phone {
namespace {

using Json = nlohmann::json;

Json EncodePose(const Rigid3& pose) {
  const auto& t = pose.translation();
  const auto& q = pose.rotation();
  return Json::array({t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
}

std::string_view StateName(localiser::AlignmentState state) {
  switch (state) {
    case localiser::AlignmentState::kNever:
      return "never";
    case localiser::AlignmentState::kCoarse:
      return "coarse";
    case localiser::AlignmentState::kFixed:
      return "fixed";
    case localiser::AlignmentState::kStale:
      return "stale";
  }
  return "unknown";
}

std::string_view SourceName(session::FixSource source) {
  return source == session::FixSource::kTile ? "tile" : "server";
}

Json EncodeTrack(const Replay& replay, const Walk& walk) {
  Json track = Json::array();
  for (const TrackPoint& point : replay.track) {
    Json pose;
    if (point.pose.map_from_device) {
      pose = EncodePose((*point.pose.map_from_device * walk.device_from_camera).rigid());
    }
    track.push_back({{"image", point.image},
                     {"seconds", point.seconds},
                     {"state", StateName(point.pose.state)},
                     {"fix_source", SourceName(point.pose.fix_source)},
                     {"epoch", point.pose.epoch},
                     {"map_from_camera", pose},
                     {"others", point.others_present},
                     {"oldest_other_s", point.oldest_other_s}});
    if (!point.apart) continue;
    track.back()["apart_p50_m"] = point.apart->p50_m;
    track.back()["apart_p95_m"] = point.apart->p95_m;
  }
  return track;
}

Json EncodeAnchors(const Replay& replay) {
  Json anchors = Json::array();
  for (const auto& anchor : replay.anchors) {
    Json first_seen;
    for (const auto& sighting : replay.sightings) {
      if (sighting.id == anchor.id) first_seen = sighting.first_seen_s;
    }
    anchors.push_back({{"id", anchor.id.text()},
                       {"owner", anchor.owner.text()},
                       {"kind", anchor.kind},
                       {"payload", anchor.payload},
                       {"revision", anchor.revision},
                       {"epoch", anchor.epoch},
                       {"map_from_anchor", EncodePose(anchor.map_from_anchor.rigid())},
                       {"first_seen_s", first_seen}});
  }
  return anchors;
}

}  // namespace

std::string EncodeReplay(const Replay& replay, const Walk& walk, const std::string& name,
                         const DeviceId& device, const session::DeviceStatistics& statistics) {
  Json latencies_ms = Json::array();
  for (const session::KeyframeTiming& timing : statistics.keyframe_timings) {
    latencies_ms.push_back(timing.total_ms);
  }
  const Json json = {{"name", name},
                     {"device", device.text()},
                     {"statistics",
                      {{"keyframes_sent", statistics.keyframes_sent},
                       {"fixes", statistics.fixes},
                       {"burst_fixes", statistics.burst_fixes},
                       {"tile_fixes", statistics.tile_fixes},
                       {"tile_refusals", statistics.tile_refusals},
                       {"refusals", statistics.refusals},
                       {"timeouts", statistics.timeouts},
                       {"fix_latency_ms", latencies_ms}}},
                     {"track", EncodeTrack(replay, walk)},
                     {"placed", replay.placed ? Json(replay.placed->text()) : Json()},
                     {"place_error", replay.place_error},
                     {"anchors", EncodeAnchors(replay)}};
  // Names and payloads are other people's bytes: what is not UTF-8 is replaced, never thrown at.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace waymark::phone

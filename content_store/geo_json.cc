// SPDX-License-Identifier: Apache-2.0
#include "content_store/geo_json.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>

#include "content_store/anchor_rules.h"
#include "content_store/internal/base64.h"
#include "content_store/internal/record_names.h"

namespace waymark::content {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const Rigid3& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation();
  return {{"translation_m", {t.x(), t.y(), t.z()}}, {"quaternion", {q.x(), q.y(), q.z(), q.w()}}};
}

Json ToFeature(const AnchorRecord& record) {
  Json properties{{"room", record.room.text()},
                  {"owner", record.owner},
                  {"kind", record.kind},
                  {"revision", record.revision},
                  {"epoch", record.epoch},
                  {"map_from_anchor", ToJson(record.map_from_anchor.rigid())},
                  {"attachments", Json::array()},
                  {"created_utc_ms", record.created_utc_ms},
                  {"changed_utc_ms", record.changed_utc_ms}};
  for (const SubmapAttachment& attachment : record.attachments) {
    properties["attachments"].push_back(
        {{"submap", attachment.submap.text()},
         {"submap_from_anchor", ToJson(attachment.submap_from_anchor.rigid())}});
  }
  properties["visibility"] = internal::NameOf(record.visibility);
  properties["editing"] = internal::NameOf(record.editing);
  if (record.expires_utc_ms) properties["expires_utc_ms"] = *record.expires_utc_ms;
  if (record.unsupported_since_epoch) {
    properties["unsupported_since_epoch"] = *record.unsupported_since_epoch;
  }
  if (record.link) {
    properties["link"] = {{"uri", record.link->uri}, {"sha256", record.link->sha256}};
  } else if (IsText(record.payload)) {
    properties["payload"] = record.payload;
  } else {
    properties["payload_base64"] = internal::EncodeBase64(record.payload);
  }
  return {{"type", "Feature"},
          {"id", record.id.text()},
          {"geometry",
           {{"type", "Point"},
            {"coordinates",
             {record.place.longitude.degrees(), record.place.latitude.degrees(),
              record.place.ellipsoid_height_m}}}},
          {"properties", std::move(properties)}};
}

}  // namespace

std::string EncodeGeoJson(const RoomSnapshot& snapshot) {
  Json features = Json::array();
  for (const AnchorRecord& record : snapshot.anchors) features.push_back(ToFeature(record));
  return Json{{"type", "FeatureCollection"},
              {"revision", snapshot.revision},
              {"features", std::move(features)}}
      .dump(2);
}

std::string EncodeGeoJson(const AnchorRecord& record) { return ToFeature(record).dump(2); }

std::string EncodeGeoJsonLine(const AnchorRecord& record) { return ToFeature(record).dump(); }

}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "content_store/anchor_rules.h"
#include "content_store/geo_json.h"
#include "content_store/internal/base64.h"
#include "content_store/internal/record_names.h"

namespace waymark::content {
namespace {

using Json = nlohmann::json;

/// A field that is not what it must be; never leaves this file.
struct Refusal {
  std::string reason;
};

const Json& Member(const Json& object, const char* name) {
  const auto found = object.is_object() ? object.find(name) : object.end();
  if (found == object.end()) throw Refusal{fmt::format("{}: expected it, found nothing", name)};
  return *found;
}

const Json* FindMember(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() || found->is_null() ? nullptr : &*found;
}

std::string Text(const Json& value, const char* name) {
  if (!value.is_string()) throw Refusal{fmt::format("{}: expected a text", name)};
  return value.get<std::string>();
}

double Real(const Json& value, const char* name) {
  if (!value.is_number()) throw Refusal{fmt::format("{}: expected a number", name)};
  return value.get<double>();
}

std::uint64_t Count(const Json& value, const char* name) {
  if (!value.is_number_unsigned()) throw Refusal{fmt::format("{}: expected a count", name)};
  return value.get<std::uint64_t>();
}

std::int64_t Time(const Json& value, const char* name) {
  const bool fits = value.is_number_integer() &&
                    (!value.is_number_unsigned() ||
                     value.get<std::uint64_t>() <= static_cast<std::uint64_t>(INT64_MAX));
  if (!fits) throw Refusal{fmt::format("{}: expected whole milliseconds", name)};
  return value.get<std::int64_t>();
}

std::vector<double> Reals(const Json& value, std::size_t least, std::size_t most,
                          const char* name) {
  if (!value.is_array() || value.size() < least || value.size() > most) {
    throw Refusal{fmt::format("{}: expected {} numbers", name, most)};
  }
  std::vector<double> numbers;
  for (const Json& number : value) numbers.push_back(Real(number, name));
  return numbers;
}

Rigid3 Pose(const Json& value, const char* name) {
  const auto t = Reals(Member(value, "translation_m"), 3, 3, name);
  const auto q = Reals(Member(value, "quaternion"), 4, 4, name);
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  // Checked here: the transform makes a unit quaternion of any.
  if (!(std::abs(rotation.norm() - 1) < 1e-6)) {
    throw Refusal{fmt::format("{}: expected a unit quaternion", name)};
  }
  return {rotation, Eigen::Vector3d(t[0], t[1], t[2])};
}

template <typename Enum, std::size_t n>
Enum Named(const std::array<std::string_view, n>& names, const Json& value, const char* field) {
  const auto found = internal::FindNamed<Enum>(names, Text(value, field));
  if (!found) throw Refusal{fmt::format("{}: expected one of {}", field, fmt::join(names, ", "))};
  return *found;
}

void ReadContent(const Json& properties, AnchorRecord& record) {
  if (const Json* link = FindMember(properties, "link")) {
    record.link = {Text(Member(*link, "uri"), "uri"), Text(Member(*link, "sha256"), "sha256")};
  }
  if (const Json* text = FindMember(properties, "payload")) record.payload = Text(*text, "payload");
  if (const Json* text = FindMember(properties, "payload_base64")) {
    auto bytes = internal::DecodeBase64(Text(*text, "payload_base64"));
    if (!bytes) throw Refusal{"payload_base64: expected Base64 with padding"};
    record.payload = *std::move(bytes);
  }
}

void ReadOptions(const Json& properties, AnchorRecord& record) {
  if (const Json* value = FindMember(properties, "owner")) record.owner = Text(*value, "owner");
  if (const Json* value = FindMember(properties, "kind")) record.kind = Text(*value, "kind");
  if (const Json* value = FindMember(properties, "epoch")) record.epoch = Count(*value, "epoch");
  if (const Json* value = FindMember(properties, "created_utc_ms")) {
    record.created_utc_ms = Time(*value, "created_utc_ms");
  }
  if (const Json* value = FindMember(properties, "changed_utc_ms")) {
    record.changed_utc_ms = Time(*value, "changed_utc_ms");
  }
  if (const Json* value = FindMember(properties, "expires_utc_ms")) {
    record.expires_utc_ms = Time(*value, "expires_utc_ms");
  }
  if (const Json* value = FindMember(properties, "unsupported_since_epoch")) {
    record.unsupported_since_epoch = Count(*value, "unsupported_since_epoch");
  }
  if (const Json* value = FindMember(properties, "visibility")) {
    record.visibility = Named<AnchorVisibility>(internal::kVisibilityNames, *value, "visibility");
  }
  if (const Json* value = FindMember(properties, "editing")) {
    record.editing = Named<AnchorEditing>(internal::kEditingNames, *value, "editing");
  }
}

AnchorRecord ReadFeature(const Json& feature) {
  const Json& properties = Member(feature, "properties");
  AnchorRecord record{.id = AnchorId(Text(Member(feature, "id"), "id")),
                      .room = RoomId(Text(Member(properties, "room"), "room"))};
  const Json& geometry = Member(feature, "geometry");
  if (Text(Member(geometry, "type"), "geometry") != "Point") {
    throw Refusal{"geometry: expected a Point"};
  }
  const auto at = Reals(Member(geometry, "coordinates"), 2, 3, "coordinates");
  record.place = {.latitude = Angle::Degrees(at[1]),
                  .longitude = Angle::Degrees(at[0]),
                  .ellipsoid_height_m = at.size() > 2 ? at[2] : 0};
  record.map_from_anchor =
      Transform<Map, Anchor>(Pose(Member(properties, "map_from_anchor"), "map_from_anchor"));
  if (const Json* attachments = FindMember(properties, "attachments")) {
    if (!attachments->is_array() || attachments->size() > kMaxAttachments) {
      throw Refusal{fmt::format("attachments: expected at most {}", kMaxAttachments)};
    }
    for (const Json& attachment : *attachments) {
      record.attachments.push_back(
          {SubmapId(Text(Member(attachment, "submap"), "submap")),
           Transform<Submap, Anchor>(
               Pose(Member(attachment, "submap_from_anchor"), "submap_from_anchor"))});
    }
  }
  ReadContent(properties, record);
  ReadOptions(properties, record);
  if (const auto valid = Validate(record); !valid) throw Refusal{valid.error().message};
  return record;
}

}  // namespace

Result<void> DecodeGeoJson(std::istream& in,
                           const std::function<Result<void>(AnchorRecord)>& take) {
  std::size_t count = 0;
  bool is_in_features = false, had_features = false;
  const auto at_event = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (depth == 1 && event == Json::parse_event_t::key) {
      is_in_features = parsed == "features";
      had_features = had_features || is_in_features;
    }
    if (depth != 2 || event != Json::parse_event_t::object_end || !is_in_features) return true;
    ++count;
    if (const auto taken = take(ReadFeature(parsed)); !taken) throw taken.error();
    return false;  // forget it
  };
  try {
    const Json root = Json::parse(in, at_event);
    const bool is_collection =
        root.is_object() && had_features && root.value("type", Json()) == "FeatureCollection";
    if (is_collection) return {};
    return MakeError(ErrorCode::kInvalidArgument, "GeoJSON: expected a FeatureCollection");
  } catch (const Refusal& refusal) {
    return MakeError(ErrorCode::kInvalidArgument, "GeoJSON: feature {}: {}", count, refusal.reason);
  } catch (const Error& error) {
    return error;
  } catch (const std::exception& exception) {  // the library's
    return MakeError(ErrorCode::kInvalidArgument, "GeoJSON: after feature {}: {}", count,
                     exception.what());
  }
}

}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
#include "mapping/store/internal/map_description.h"

#include "mapping/store/internal/json_reader.h"

namespace waymark::mapping::internal {
namespace {

Json EncodeOrigin(const GeoPoint& origin) {
  // Radians, because degrees would not come back to the last bit.
  return Json{{"latitude_rad", origin.latitude.radians()},
              {"longitude_rad", origin.longitude.radians()},
              {"ellipsoid_height_m", origin.ellipsoid_height_m}};
}

Result<double> DecodeNumber(const JsonReader& object, std::string_view key) {
  WAYMARK_TRY_ASSIGN(const auto member, object.Member(key));
  return member.Number();
}

Result<GeoPoint> DecodeOrigin(const JsonReader& object) {
  WAYMARK_TRY_ASSIGN(const double latitude_rad, DecodeNumber(object, "latitude_rad"));
  WAYMARK_TRY_ASSIGN(const double longitude_rad, DecodeNumber(object, "longitude_rad"));
  WAYMARK_TRY_ASSIGN(const double height_m, DecodeNumber(object, "ellipsoid_height_m"));
  const GeoPoint origin{Angle::Radians(latitude_rad), Angle::Radians(longitude_rad), height_m};
  if (!origin.Validate()) return object.Wrong("a place on earth");
  return origin;
}

}  // namespace

Result<MapDescription> Canonical(const MapDescription& description) {
  if (description.id.empty()) {
    return Error{ErrorCode::kInvalidArgument, "map description: expected an id, found none"};
  }
  WAYMARK_TRY(description.origin.Validate());
  MapDescription canonical = description;
  if (canonical.options_json.empty()) canonical.options_json = "{}";
  const auto options = ParseJson(canonical.options_json);
  if (!options || !options->is_object()) {
    return Error{ErrorCode::kInvalidArgument,
                 "map description: expected options as a JSON object, found something else"};
  }
  canonical.options_json = options->dump(-1, ' ', false, Json::error_handler_t::replace);
  return canonical;
}

std::string EncodeMapDescription(const MapDescription& description) {
  return DumpDocument(Json{{"format_version", kMapFormatVersion},
                           {"id", description.id},
                           {"origin", EncodeOrigin(description.origin)},
                           {"is_geo_aligned", description.is_geo_aligned},
                           {"options", Json::parse(description.options_json)}});
}

Result<MapDescription> DecodeMapDescription(std::string_view json, std::string_view name) {
  WAYMARK_TRY_ASSIGN(const Json document, ParseDocument(json, name));
  const JsonReader root(document, fmt::format("{}: ", name));
  MapDescription description;
  WAYMARK_TRY_ASSIGN(const auto id, root.Member("id"));
  WAYMARK_TRY_ASSIGN(description.id, id.Text());
  if (description.id.empty()) return id.Wrong("an id");
  WAYMARK_TRY_ASSIGN(const auto origin, root.Member("origin"));
  WAYMARK_TRY_ASSIGN(description.origin, DecodeOrigin(origin));
  WAYMARK_TRY_ASSIGN(const auto aligned, root.Member("is_geo_aligned"));
  WAYMARK_TRY_ASSIGN(description.is_geo_aligned, aligned.Flag());
  WAYMARK_TRY_ASSIGN(const auto options, root.Member("options"));
  if (!options.json().is_object()) return options.Wrong("an object");
  description.options_json = options.json().dump(-1, ' ', false, Json::error_handler_t::replace);
  return description;
}

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/export_geojson.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "mapping/io/internal/export_images.h"

namespace waymark::mapping {
namespace {

using nlohmann::ordered_json;

/// Longitude first; nanodegrees are a tenth of a millimetre.
ordered_json Position(const GeoPoint& place) {
  const auto rounded = [](double degrees) { return std::round(degrees * 1e9) / 1e9; };
  return {rounded(place.longitude.degrees()), rounded(place.latitude.degrees()),
          std::round(place.ellipsoid_height_m * 1e3) / 1e3};
}

ordered_json Feature(const char* type, ordered_json coordinates, ordered_json properties) {
  return {{"type", "Feature"},
          {"geometry", {{"type", type}, {"coordinates", std::move(coordinates)}}},
          {"properties", std::move(properties)}};
}

ordered_json Disc(const GeoSubmap& submap, const TangentPlane& plane) {
  constexpr int kCorners = 48;
  ordered_json ring = ordered_json::array();
  for (int i = 0; i <= kCorners; ++i) {  // counterclockwise, closed
    const double angle = 2 * M_PI * (i % kCorners) / kCorners;
    const Eigen::Vector3d corner =
        submap.centre.coordinates() +
        submap.radius_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    ring.push_back(Position(plane.ToGeo(Point<Map>(corner))));
  }
  return Feature("Polygon", ordered_json::array({std::move(ring)}),
                 {{"kind", "submap"},
                  {"id", submap.id.text()},
                  {"radius_m", submap.radius_m},
                  {"images", submap.submap.images().size()},
                  {"landmarks", submap.submap.landmark_count()}});
}

}  // namespace

std::string EncodeGeoJson(const std::vector<GeoSubmap>& submaps, const GeoPoint& origin) {
  const TangentPlane plane(origin);
  ordered_json features = ordered_json::array();
  std::vector<ExportSubmap> exported;
  for (const GeoSubmap& submap : submaps) {
    features.push_back(Disc(submap, plane));
    exported.push_back(submap.submap);
  }
  for (const internal::ExportedImage& image : internal::MergeImages(exported).images) {
    const GeoPoint place = plane.ToGeo(Point<Map>(image.map_from_camera.translation()));
    const SubmapImage& source = exported[image.submap].images()[image.image];
    features.push_back(Feature("Point", Position(place),
                               {{"kind", "image"},
                                {"name", source.name},
                                {"experience", source.experience.text()},
                                {"submap", submaps[image.submap].id.text()}}));
  }
  const ordered_json collection{{"type", "FeatureCollection"}, {"features", std::move(features)}};
  return collection.dump(1) + "\n";
}

}  // namespace waymark::mapping

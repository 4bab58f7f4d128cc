// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/geometry/geodesy.h"
#include "mapping/io/export_submap.h"

namespace waymark::mapping {

/// A submap as geographic software shows it.
struct GeoSubmap {
  SubmapId id;
  ExportSubmap submap;
  Point<Map> centre;
  double radius_m;
};

/// An RFC 7946 FeatureCollection, WGS84: each submap as a polygon around its disc with id, radius
/// and counts, and each image of an experience as a point with its name, its submap and the height
/// above the ellipsoid. `origin` is the map's.
std::string EncodeGeoJson(const std::vector<GeoSubmap>& submaps, const GeoPoint& origin);

}  // namespace waymark::mapping

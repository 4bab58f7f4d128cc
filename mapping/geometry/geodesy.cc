// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/geodesy.h"

#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/LocalCartesian.hpp>

#include <cmath>

namespace waymark {

Result<void> GeoPoint::Validate() const {
  const bool finite = std::isfinite(latitude.radians()) && std::isfinite(longitude.radians()) &&
                      std::isfinite(ellipsoid_height_m);
  constexpr double kSlackDegrees = 1e-9;  // rounding of a degree at its limit
  if (!finite || std::abs(latitude.degrees()) > 90 + kSlackDegrees ||
      std::abs(longitude.degrees()) > 180 + kSlackDegrees) {
    return MakeError(
        ErrorCode::kInvalidArgument,
        "expected latitude in [-90, 90], longitude in [-180, 180] and a finite height, "
        "found {}, {}, {} m",
        latitude.degrees(), longitude.degrees(), ellipsoid_height_m);
  }
  return {};
}

struct TangentPlane::Projection {
  GeographicLib::LocalCartesian cartesian;
};

TangentPlane::TangentPlane(const GeoPoint& origin)
    : origin_(origin),
      projection_(std::make_shared<Projection>(Projection{GeographicLib::LocalCartesian(
          origin.latitude.degrees(), origin.longitude.degrees(), origin.ellipsoid_height_m)})) {}

Point<Map> TangentPlane::ToMap(const GeoPoint& place) const {
  double x = 0, y = 0, z = 0;
  projection_->cartesian.Forward(place.latitude.degrees(), place.longitude.degrees(),
                                 place.ellipsoid_height_m, x, y, z);
  return {x, y, z};
}

GeoPoint TangentPlane::ToGeo(const Point<Map>& position) const {
  double latitude = 0, longitude = 0, height = 0;
  const Eigen::Vector3d& x = position.coordinates();
  projection_->cartesian.Reverse(x.x(), x.y(), x.z(), latitude, longitude, height);
  return {Angle::Degrees(latitude), Angle::Degrees(longitude), height};
}

double GeodesicDistance(const GeoPoint& a, const GeoPoint& b) {
  double distance_m = 0;
  GeographicLib::Geodesic::WGS84().Inverse(a.latitude.degrees(), a.longitude.degrees(),
                                           b.latitude.degrees(), b.longitude.degrees(), distance_m);
  return distance_m;
}

}  // namespace waymark

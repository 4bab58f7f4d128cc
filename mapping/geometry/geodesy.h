// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "mapping/base/result.h"
#include "mapping/geometry/angle.h"
#include "mapping/geometry/frames.h"

namespace waymark {

/// A place on the WGS84 ellipsoid.
struct GeoPoint {
  Angle latitude;   ///< [-90, 90] degrees, north positive
  Angle longitude;  ///< [-180, 180] degrees, east positive
  double ellipsoid_height_m = 0;

  /// Errors: InvalidArgument for values that are not finite or out of range.
  Result<void> Validate() const;
};

/// The map frame: the east-north-up tangent plane at an origin, metres. Immutable, thread-safe.
class TangentPlane {
 public:
  explicit TangentPlane(const GeoPoint& origin);

  const GeoPoint& origin() const { return origin_; }
  Point<Map> ToMap(const GeoPoint& place) const;
  GeoPoint ToGeo(const Point<Map>& position) const;

 private:
  struct Projection;

  GeoPoint origin_;
  std::shared_ptr<const Projection> projection_;
};

/// Metres along the ellipsoid between two places, heights ignored.
double GeodesicDistance(const GeoPoint& a, const GeoPoint& b);

}  // namespace waymark

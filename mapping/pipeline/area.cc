// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/area.h"

#include <cmath>

namespace waymark::mapping {
namespace {

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

Result<PlaneArea> PlaneArea::Create(const Area& area, const TangentPlane& plane) {
  constexpr double kMinAreaM2 = 1e-3;
  if (area.size() < 3) {
    return MakeError(ErrorCode::kInvalidArgument, "area: expected at least 3 corners, found {}",
                     area.size());
  }
  PlaneArea result;
  for (const GeoPoint& corner : area) {
    WAYMARK_TRY(corner.Validate());
    const GeoPoint on_plane{corner.latitude, corner.longitude, plane.origin().ellipsoid_height_m};
    result.corners_.push_back(plane.ToMap(on_plane).coordinates().head<2>());
  }
  double twice_m2 = 0;
  for (std::size_t i = 0; i < area.size(); ++i) {
    twice_m2 += Cross(result.corners_[i], result.corners_[(i + 1) % area.size()]);
  }
  if (!(std::abs(twice_m2) > 2 * kMinAreaM2)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "area: expected corners around an inside, found {} on a line", area.size());
  }
  return result;
}

bool PlaneArea::Contains(const Point<Map>& position) const {
  const Eigen::Vector2d p = position.coordinates().head<2>();
  bool is_inside = false;  // by the number of edges that a ray to the east crosses
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Eigen::Vector2d& a = corners_[i];
    const Eigen::Vector2d& b = corners_[(i + 1) % corners_.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    const double x = a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (x > p.x()) is_inside = !is_inside;
  }
  return is_inside;
}

}  // namespace waymark::mapping

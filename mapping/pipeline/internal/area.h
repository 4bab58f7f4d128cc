// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <vector>

#include "mapping/pipeline/removing.h"

namespace waymark::mapping {

/// An area on the map's plane, ready to be asked. Immutable, thread-safe.
class PlaneArea {
 public:
  /// Errors: InvalidArgument for fewer than 3 corners, corners off the earth, or no inside.
  static Result<PlaneArea> Create(const Area& area, const TangentPlane& plane);

  /// By east and north alone. Points on the border may count as either.
  bool Contains(const Point<Map>& position) const;

 private:
  std::vector<Eigen::Vector2d> corners_;
};

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/rough_distance.h"

#include <algorithm>
#include <cmath>

namespace waymark::content::internal {
namespace {

// Metres on WGS84 per radian of S2's sphere lie between the smallest and the largest radius of
// curvature, 6335439 and 6399594 m. The middle is off by a known part at most, either way.
constexpr double kMetresPerRadian = 6367516.5;
constexpr double kShapeError = 0.00504;

}  // namespace

double RoughDistance(const CellPlace& a, const CellPlace& b) {
  const double half_lat = std::sin((a.latitude_rad - b.latitude_rad) / 2);
  const double half_lon = std::sin((a.longitude_rad - b.longitude_rad) / 2);
  const double h = half_lat * half_lat +
                   std::cos(a.latitude_rad) * std::cos(b.latitude_rad) * half_lon * half_lon;
  return kMetresPerRadian * 2 * std::asin(std::sqrt(std::min(1.0, h)));
}

double LargestRough(double true_m) {
  return true_m * (1 + kShapeError) / (1 - kShapeError) + 2 * kCellError_m;
}

double LargestTrue(double rough_m) { return (rough_m + 2 * kCellError_m) * (1 + kShapeError); }

}  // namespace waymark::content::internal

// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/mapped_lens.h"

#include <algorithm>
#include <cmath>

#include "mapping/geometry/lens_kind.h"

namespace waymark::localiser::internal {
namespace {

bool IsNear(double focal_px, double stated_px) {
  constexpr double kShare = 0.05;  // mapping moved a wrong calibration by 2.6 %
  return std::abs(focal_px - stated_px) <= kShare * stated_px;
}

/// Zero for lenses without.
Eigen::Vector2d Tangential(const CameraModel& camera) {
  if (camera.kind() != CameraKind::kOpenCv) return Eigen::Vector2d::Zero();
  return {camera.parameters()[6], camera.parameters()[7]};
}

bool IsTheSame(const CameraModel& stated, const CameraModel& mapped) {
  const bool has_its_kind =
      mapped.kind() == stated.kind() || mapped.kind() == WithRadialDistortion(stated.kind());
  return has_its_kind && mapped.width_px() == stated.width_px() &&
         mapped.height_px() == stated.height_px() &&
         mapped.PrincipalPoint() == stated.PrincipalPoint() &&
         Tangential(mapped) == Tangential(stated) && IsNear(mapped.FocalX(), stated.FocalX()) &&
         IsNear(mapped.FocalY(), stated.FocalY());
}

}  // namespace

CameraModel MappedLens(const CameraModel& stated, std::span<const CameraModel> mapped) {
  const auto same = std::ranges::find_if(
      mapped, [&](const CameraModel& camera) { return IsTheSame(stated, camera); });
  return same == mapped.end() ? stated : *same;
}

}  // namespace waymark::localiser::internal

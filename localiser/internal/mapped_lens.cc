// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/mapped_lens.h"

#include <algorithm>
#include <cmath>

#include "mapping/geometry/lens_kind.h"
#include "mapping/geometry/resized_camera.h"

namespace waymark::localiser::internal {
namespace {

// Pictures are resized about the corner or about the centre of the first pixel.
constexpr double kMaxCentreOffsetPx = 0.5;

bool IsNear(double focal_px, double stated_px) {
  constexpr double kShare = 0.05;  // mapping moved a wrong calibration by 2.6 %
  return std::abs(focal_px - stated_px) <= kShare * stated_px;
}

/// Zero for lenses without.
Eigen::Vector2d Tangential(const CameraModel& camera) {
  if (camera.kind() != CameraKind::kOpenCv) return Eigen::Vector2d::Zero();
  return {camera.parameters()[6], camera.parameters()[7]};
}

/// Pixels of `stated` per pixel of `mapped`, were its pictures resized.
Eigen::Vector2d ResizedBy(const CameraModel& stated, const CameraModel& mapped) {
  return {static_cast<double>(stated.width_px()) / mapped.width_px(),
          static_cast<double>(stated.height_px()) / mapped.height_px()};
}

/// Whether the pictures have the same sides but for rounding: cut ones have not.
bool HasItsSides(const CameraModel& stated, const CameraModel& mapped) {
  const Eigen::Vector2d by = ResizedBy(stated, mapped);
  return std::abs(by.x() * mapped.height_px() - stated.height_px()) <= 1 ||
         std::abs(by.y() * mapped.width_px() - stated.width_px()) <= 1;
}

bool IsTheSame(const CameraModel& stated, const CameraModel& mapped) {
  if (mapped.kind() != stated.kind() && mapped.kind() != WithRadialDistortion(stated.kind())) {
    return false;
  }
  const Eigen::Vector2d by = ResizedBy(stated, mapped);
  const Eigen::Vector2d offset_px =
      mapped.PrincipalPoint().cwiseProduct(by) - stated.PrincipalPoint();
  return HasItsSides(stated, mapped) &&
         offset_px.cwiseAbs().maxCoeff() <=
             (by == Eigen::Vector2d::Ones() ? 0 : kMaxCentreOffsetPx) &&
         Tangential(mapped) == Tangential(stated) &&
         IsNear(by.x() * mapped.FocalX(), stated.FocalX()) &&
         IsNear(by.y() * mapped.FocalY(), stated.FocalY());
}

}  // namespace

CameraModel MappedLens(const CameraModel& stated, std::span<const CameraModel> mapped) {
  const auto same = std::ranges::find_if(
      mapped, [&](const CameraModel& camera) { return IsTheSame(stated, camera); });
  if (same == mapped.end()) return stated;
  return WithPrincipalPoint(ResizeCamera(*same, stated.width_px(), stated.height_px()),
                            stated.PrincipalPoint());
}

}  // namespace waymark::localiser::internal

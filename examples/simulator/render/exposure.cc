// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/exposure.h"

#include <algorithm>
#include <cmath>

namespace waymark::simulator {
namespace {

constexpr double kNear = 5;  // metres; what is nearer is drawn out in steps
constexpr double kMostLooks = 8;

/// How far the image moves in the middle meanwhile, pixels.
double Smear(const ViewRays& rays, const CameraMotion& motion, double exposure_s) {
  const int column = rays.width_px() / 2;
  const int row = rays.height_px() / 2;
  const double pixel_rad = (rays.At(column + 1, row) - rays.At(column, row)).norm();
  const double radps = motion.turning_radps.norm() + motion.velocity_mps.norm() / kNear;
  return radps * exposure_s / pixel_rad;
}

Rigid3 PoseAfter(const Rigid3& world_from_camera, const CameraMotion& motion, double time_s) {
  return {world_from_camera.rotation() * RotationFromVector(time_s * motion.turning_radps),
          world_from_camera.translation() + time_s * motion.velocity_mps};
}

}  // namespace

Radiance RenderExposure(const Renderer& renderer, const ViewRays& rays,
                        const Rigid3& world_from_camera, const CameraMotion& motion,
                        Antialiasing antialiasing) {
  const double exposure_s = motion.shutter * renderer.lighting().exposure_s;
  const int looks =
      static_cast<int>(std::clamp(std::ceil(Smear(rays, motion, exposure_s)), 1.0, kMostLooks));
  if (looks == 1) return renderer.Render(rays, world_from_camera, antialiasing);
  Radiance sum;
  for (int i = 0; i < looks; ++i) {
    const double time_s = exposure_s * ((i + 0.5) / looks - 0.5);
    const Radiance look = renderer.Render(rays, PoseAfter(world_from_camera, motion, time_s),
                                          Antialiasing::kNone);  // the mean smooths edges
    if (i == 0) sum = {look.width_px, look.height_px, std::vector<float>(look.values.size())};
    // Light adds up, display values do not: squares are near enough to the power of 2.2.
    for (std::size_t j = 0; j < look.values.size(); ++j) {
      sum.values[j] += look.values[j] * look.values[j];
    }
  }
  for (float& value : sum.values) value = std::sqrt(value / static_cast<float>(looks));
  return sum;
}

}  // namespace waymark::simulator

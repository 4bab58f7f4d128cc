// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/resized_camera.h"

#include <cmath>
#include <vector>

#include "mapping/geometry/lens_kind.h"

namespace waymark {
namespace {

std::vector<double> ParametersOf(const CameraModel& camera) {
  return {camera.parameters().begin(), camera.parameters().end()};
}

}  // namespace

CameraModel ResizeCamera(const CameraModel& camera, int width_px, int height_px) {
  const double x = static_cast<double>(width_px) / camera.width_px();
  const double y = static_cast<double>(height_px) / camera.height_px();
  std::vector<double> parameters = ParametersOf(camera);
  const bool has_two = HasTwoFocals(camera.kind());
  // Sizes are whole pixels, so that the two scales differ by a hair.
  parameters[0] *= has_two ? x : std::sqrt(x * y);
  if (has_two) parameters[1] *= y;
  const auto resized = CameraModel::Create(camera.kind(), width_px, height_px, parameters);
  return WithPrincipalPoint(*resized, camera.PrincipalPoint().cwiseProduct(Eigen::Vector2d(x, y)));
}

CameraModel WithPrincipalPoint(const CameraModel& camera, const Eigen::Vector2d& point_px) {
  std::vector<double> parameters = ParametersOf(camera);
  const std::size_t first = HasTwoFocals(camera.kind()) ? 2 : 1;
  parameters[first] = point_px.x();
  parameters[first + 1] = point_px.y();
  return *CameraModel::Create(camera.kind(), camera.width_px(), camera.height_px(), parameters);
}

}  // namespace waymark

// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/camera_model.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

#include "mapping/geometry/lens_kind.h"

namespace waymark {
namespace {

struct KindEntry {
  CameraKind kind;
  std::string_view name;
  std::size_t parameter_count;
};

constexpr std::array<KindEntry, 5> kKinds{{
    {CameraKind::kSimplePinhole, "SIMPLE_PINHOLE", 3},
    {CameraKind::kPinhole, "PINHOLE", 4},
    {CameraKind::kSimpleRadial, "SIMPLE_RADIAL", 4},
    {CameraKind::kRadial, "RADIAL", 5},
    {CameraKind::kOpenCv, "OPENCV", 8},
}};

const KindEntry& Entry(CameraKind kind) {
  const auto* entry =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& e) { return e.kind == kind; });
  CHECK(entry != kKinds.end());
  return *entry;
}

}  // namespace

std::string_view CameraKindName(CameraKind kind) { return Entry(kind).name; }

std::size_t ParameterCount(CameraKind kind) { return Entry(kind).parameter_count; }

std::optional<CameraKind> FindCameraKind(std::string_view name) {
  for (const auto& entry : kKinds) {
    if (entry.name == name) return entry.kind;
  }
  return std::nullopt;
}

Result<CameraModel> CameraModel::Create(CameraKind kind, int width_px, int height_px,
                                        std::span<const double> parameters) {
  const std::string_view name = CameraKindName(kind);
  if (width_px <= 0 || height_px <= 0) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "camera {}: expected a positive image size, found {} x {}", name, width_px,
                     height_px);
  }
  if (parameters.size() != ParameterCount(kind)) {
    return MakeError(ErrorCode::kInvalidArgument, "camera {}: expected {} parameters, found {}",
                     name, ParameterCount(kind), parameters.size());
  }
  if (!std::all_of(parameters.begin(), parameters.end(),
                   [](double p) { return std::isfinite(p); })) {
    return MakeError(ErrorCode::kInvalidArgument, "camera {}: expected finite parameters", name);
  }
  if (parameters[0] <= 0 || (HasTwoFocals(kind) && parameters[1] <= 0)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "camera {}: expected a focal length > 0, found {}", name, parameters[0]);
  }
  CameraModel camera(kind, width_px, height_px);
  std::copy(parameters.begin(), parameters.end(), camera.parameters_.begin());
  return camera;
}

double CameraModel::FocalY() const { return parameters_[HasTwoFocals(kind_) ? 1 : 0]; }

Eigen::Vector2d CameraModel::PrincipalPoint() const {
  const std::size_t first = HasTwoFocals(kind_) ? 2 : 1;
  return {parameters_[first], parameters_[first + 1]};
}

CameraModel CameraModel::WithScaledFocal(double factor) const {
  CHECK(factor > 0, "a focal length times {}", factor);
  CameraModel scaled = *this;
  scaled.parameters_[0] *= factor;
  if (HasTwoFocals(kind_)) scaled.parameters_[1] *= factor;
  return scaled;
}

std::optional<Eigen::Vector2d> CameraModel::Project(const Eigen::Vector3d& x_in_camera) const {
  if (!(x_in_camera.z() > 0)) return std::nullopt;
  const Eigen::Vector2d normalized = x_in_camera.head<2>() / x_in_camera.z();
  return ProjectNormalized<double>(kind_, parameters_.data(), normalized);
}

Eigen::Vector2d CameraModel::Normalize(const Eigen::Vector2d& pixel_px) const {
  const Eigen::Vector2d focal(FocalX(), FocalY());
  Eigen::Vector2d x = (pixel_px - PrincipalPoint()).cwiseQuotient(focal);
  if (kind_ == CameraKind::kSimplePinhole || kind_ == CameraKind::kPinhole) return x;
  // Newton's method on the distortion, with differences as derivatives: the model is smooth and
  // the start is within the distortion of the answer, so a handful of steps reach rounding.
  constexpr int kMaxIterations = 20;
  constexpr double kStep = 1e-6;
  for (int i = 0; i < kMaxIterations; ++i) {
    const auto project = [&](const Eigen::Vector2d& at) {
      return ProjectNormalized<double>(kind_, parameters_.data(), at);
    };
    const Eigen::Vector2d residual = project(x) - pixel_px;
    Eigen::Matrix2d jacobian;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
      jacobian.col(axis) = (project(x + step) - project(x - step)) / (2 * kStep);
    }
    if (!(std::abs(jacobian.determinant()) > 1e-9 * focal.prod())) break;  // beyond the model
    const Eigen::Vector2d delta = jacobian.inverse() * residual;
    x -= delta;
    if (delta.squaredNorm() < 1e-24) break;
  }
  return x;
}

Eigen::Vector3d CameraModel::Unproject(const Eigen::Vector2d& pixel_px) const {
  return Normalize(pixel_px).homogeneous().normalized();
}

}  // namespace waymark

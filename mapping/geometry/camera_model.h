// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "mapping/base/result.h"

namespace waymark {

/// Which lens model; names and parameter orders are those of COLMAP and kapture.
enum class CameraKind : std::uint8_t {
  kSimplePinhole,  ///< f, cx, cy
  kPinhole,        ///< fx, fy, cx, cy
  kSimpleRadial,   ///< f, cx, cy, k
  kRadial,         ///< f, cx, cy, k1, k2
  kOpenCv,         ///< fx, fy, cx, cy, k1, k2, p1, p2
};

std::string_view CameraKindName(CameraKind kind);
std::optional<CameraKind> FindCameraKind(std::string_view name);
std::size_t ParameterCount(CameraKind kind);

/// Intrinsics of a camera. Frame: camera (x right, y down, z forward); the centre of the top left
/// pixel is at (0.5, 0.5), as in COLMAP. Immutable value.
class CameraModel {
 public:
  /// Errors: InvalidArgument for a size of 0, a wrong parameter count, values that are not finite
  /// or a focal length <= 0.
  static Result<CameraModel> Create(CameraKind kind, int width_px, int height_px,
                                    std::span<const double> parameters);

  CameraKind kind() const { return kind_; }
  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  std::span<const double> parameters() const {
    return std::span(parameters_).first(ParameterCount(kind_));
  }
  double FocalX() const { return parameters_[0]; }
  double FocalY() const;
  Eigen::Vector2d PrincipalPoint() const;
  /// The same lens with its focal lengths multiplied; the factor is positive.
  CameraModel WithScaledFocal(double factor) const;

  /// The pixel that sees a direction; nothing for points at or behind the camera (z <= 0).
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& x_in_camera) const;
  /// The unit direction that a pixel sees. Distortion is undone to below 1e-10 of the focal length
  /// wherever the model is invertible.
  Eigen::Vector3d Unproject(const Eigen::Vector2d& pixel_px) const;
  /// (x/z, y/z) of that direction.
  Eigen::Vector2d Normalize(const Eigen::Vector2d& pixel_px) const;

  bool Contains(const Eigen::Vector2d& pixel_px) const {
    return pixel_px.x() >= 0 && pixel_px.y() >= 0 && pixel_px.x() < width_px_ &&
           pixel_px.y() < height_px_;
  }

  friend bool operator==(const CameraModel&, const CameraModel&) = default;

 private:
  CameraModel(CameraKind kind, int width_px, int height_px)
      : kind_(kind), width_px_(width_px), height_px_(height_px) {}

  CameraKind kind_;
  int width_px_;
  int height_px_;
  std::array<double, 8> parameters_{};
};

/// The same projection for automatic differentiation. `normalized` is (x/z, y/z).
/// Source: Brown-Conrady radial and tangential terms as in OpenCV and COLMAP.
template <typename T>
Eigen::Matrix<T, 2, 1> ProjectNormalized(CameraKind kind, const T* parameters,
                                         const Eigen::Matrix<T, 2, 1>& normalized) {
  const T x = normalized.x();
  const T y = normalized.y();
  const T r2 = x * x + y * y;
  switch (kind) {
    case CameraKind::kSimplePinhole:
      return {parameters[0] * x + parameters[1], parameters[0] * y + parameters[2]};
    case CameraKind::kPinhole:
      return {parameters[0] * x + parameters[2], parameters[1] * y + parameters[3]};
    case CameraKind::kSimpleRadial: {
      const T radial = T(1) + parameters[3] * r2;
      return {parameters[0] * radial * x + parameters[1],
              parameters[0] * radial * y + parameters[2]};
    }
    case CameraKind::kRadial: {
      const T radial = T(1) + r2 * (parameters[3] + parameters[4] * r2);
      return {parameters[0] * radial * x + parameters[1],
              parameters[0] * radial * y + parameters[2]};
    }
    case CameraKind::kOpenCv: {
      const T radial = T(1) + r2 * (parameters[4] + parameters[5] * r2);
      const T tangential_x = T(2) * parameters[6] * x * y + parameters[7] * (r2 + T(2) * x * x);
      const T tangential_y = parameters[6] * (r2 + T(2) * y * y) + T(2) * parameters[7] * x * y;
      return {parameters[0] * (radial * x + tangential_x) + parameters[2],
              parameters[1] * (radial * y + tangential_y) + parameters[3]};
    }
  }
  return {x, y};
}

}  // namespace waymark

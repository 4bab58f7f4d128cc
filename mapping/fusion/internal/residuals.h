// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace waymark::mapping {

/// A similarity as the solver holds it: quaternion x, y, z, w; translation; log of the scale.
inline constexpr int kPlaceSize = 8;

/// The place's parameters seen as geometry.
template <typename T>
struct PlaceView {
  explicit PlaceView(const T* values)
      : rotation(values), translation(values + 4), log_scale(values[7]) {}

  Eigen::Matrix<T, 3, 1> Apply(const Eigen::Vector3d& x_in_submap) const {
    using std::exp;
    const Eigen::Matrix<T, 3, 1> x = x_in_submap.cast<T>();
    return exp(log_scale) * (rotation * x) + translation;
  }

  Eigen::Map<const Eigen::Quaternion<T>> rotation;
  Eigen::Map<const Eigen::Matrix<T, 3, 1>> translation;
  T log_scale;
};

/// The rotation vector of a small rotation: exact to third order and smooth at zero.
template <typename T>
Eigen::Matrix<T, 3, 1> SmallRotationVector(const Eigen::Quaternion<T>& rotation) {
  const T sign = rotation.w() < T(0) ? T(-2) : T(2);
  return sign * rotation.vec();
}

/// The displacement of one image between two submaps: position over orientation, in sigmas.
/// Source: Platinsky et al. 2020, eq. (2), first sum; orientation is ours.
struct SharedImageResidual {
  Eigen::Vector3d position_in_first;
  Eigen::Vector3d position_in_second;
  Eigen::Quaterniond first_from_camera;
  Eigen::Quaterniond second_from_camera;
  double inverse_sigma_m;
  double inverse_sigma_rad;

  template <typename T>
  bool operator()(const T* first, const T* second, T* residuals) const {
    const PlaceView<T> a(first);
    const PlaceView<T> b(second);
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r.template head<3>() =
        T(inverse_sigma_m) * (a.Apply(position_in_first) - b.Apply(position_in_second));
    const Eigen::Quaternion<T> by_first = a.rotation * first_from_camera.cast<T>();
    const Eigen::Quaternion<T> by_second = b.rotation * second_from_camera.cast<T>();
    r.template tail<3>() =
        T(inverse_sigma_rad) * SmallRotationVector<T>(by_first.conjugate() * by_second);
    return true;
  }
};

/// An image's distance to its GNSS fix, in sigmas. Source: eq. (2), second sum.
struct GnssResidual {
  Eigen::Vector3d position_in_submap;
  Eigen::Vector3d gnss_in_map;
  double inverse_sigma_m;

  template <typename T>
  bool operator()(const T* place, T* residuals) const {
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residuals);
    r = T(inverse_sigma_m) *
        (PlaceView<T>(place).Apply(position_in_submap) - gnss_in_map.cast<T>());
    return true;
  }
};

/// How far the submap's z axis leans from up, in sigmas.
struct GravityResidual {
  Eigen::Vector3d up_in_map;
  double inverse_sigma_rad;

  template <typename T>
  bool operator()(const T* place, T* residuals) const {
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residuals);
    const Eigen::Matrix<T, 3, 1> z = Eigen::Vector3d::UnitZ().cast<T>();
    r = T(inverse_sigma_rad) * (PlaceView<T>(place).rotation * z - up_in_map.cast<T>());
    return true;
  }
};

/// How far the scale strays from its first guess, in sigmas.
struct ScaleResidual {
  double log_scale;
  double inverse_sigma;

  template <typename T>
  bool operator()(const T* place, T* residuals) const {
    residuals[0] = T(inverse_sigma) * (place[7] - T(log_scale));
    return true;
  }
};

}  // namespace waymark::mapping

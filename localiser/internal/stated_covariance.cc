// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/stated_covariance.h"

#include <cmath>

namespace waymark::localiser::internal {
namespace {

constexpr double kDependence = 1.5;     // on variances
constexpr double kImageShiftPx = 0.11;  // standard deviation per axis
constexpr double kMapShare = 2.5e-4;    // of the distance to what is seen, per axis

}  // namespace

Eigen::Matrix<double, 6, 6> StatedCovariance(const Eigen::Matrix<double, 6, 6>& of_independent,
                                             const CameraModel& camera, double distance) {
  const double turn_rad = kImageShiftPx / camera.FocalX();
  Eigen::Matrix<double, 6, 6> stated = kDependence * of_independent;
  stated.diagonal().head<3>().array() += std::pow(kMapShare * distance, 2);
  stated.diagonal().tail<3>().array() += turn_rad * turn_rad;
  return stated;
}

}  // namespace waymark::localiser::internal

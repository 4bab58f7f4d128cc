// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/gravity.h"

#include <Eigen/LU>

namespace waymark::localiser::internal {

UncertainPose WithGravity(const UncertainPose& seen, const Eigen::Vector3d& up_in_camera,
                          Angle sigma) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  // The stated up in the map, which a turn by r moves by r x z where it is nearly z.
  const Eigen::Vector2d lean = (seen.map_from_camera.rotation() * up_in_camera).head<2>();
  Eigen::Matrix<double, 2, 6> by_delta = Eigen::Matrix<double, 2, 6>::Zero();
  by_delta(0, 4) = 1;
  by_delta(1, 3) = -1;
  const Eigen::Matrix<double, 6, 2> covariance_by_delta = seen.covariance * by_delta.transpose();
  const Eigen::Matrix2d expected = by_delta * covariance_by_delta +
                                   sigma.radians() * sigma.radians() * Eigen::Matrix2d::Identity();
  const Eigen::Matrix<double, 6, 2> gain = covariance_by_delta * expected.inverse();
  const Vector6 delta = -gain * lean;
  const Eigen::Matrix<double, 6, 6> covariance =
      seen.covariance - gain * covariance_by_delta.transpose();
  return {Perturb(seen.map_from_camera, delta), (covariance + covariance.transpose()) / 2};
}

}  // namespace waymark::localiser::internal

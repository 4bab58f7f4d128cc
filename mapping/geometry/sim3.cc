// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/sim3.h"

#include <Eigen/SVD>

namespace waymark {

Rigid3 CarryPose(const Sim3& c_from_b, const Rigid3& b_from_a) {
  return {c_from_b.rotation() * b_from_a.rotation(), c_from_b * b_from_a.translation()};
}

Result<Sim3> EstimateSimilarity(std::span<const Eigen::Vector3d> from,
                                std::span<const Eigen::Vector3d> to, bool fixed_scale) {
  if (from.size() != to.size() || from.size() < 3) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "similarity: expected equally many points, at least 3, found {} and {}",
                     from.size(), to.size());
  }
  const auto count = static_cast<double>(from.size());
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    from_mean += from[i] / count;
    to_mean += to[i] / count;
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // Umeyama eq. (38)
  double from_variance = 0;                              // eq. (36)
  for (std::size_t i = 0; i < from.size(); ++i) {
    covariance += (to[i] - to_mean) * (from[i] - from_mean).transpose() / count;
    from_variance += (from[i] - from_mean).squaredNorm() / count;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& singular = svd.singularValues();
  if (!(singular(1) > 1e-12 * singular(0)) || !(from_variance > 0)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "similarity: the {} points lie on one line or in one place", from.size());
  }
  Eigen::Vector3d sign(1, 1, 1);  // eq. (39): a rotation, not a reflection
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign(2) = -1;
  const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  const double scale = fixed_scale ? 1 : singular.dot(sign) / from_variance;  // eq. (42)
  return Sim3(scale, Eigen::Quaterniond(rotation), to_mean - scale * (rotation * from_mean));
}

}  // namespace waymark

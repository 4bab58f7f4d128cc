// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/up_direction.h"

#include <Eigen/Cholesky>

#include <cmath>
#include <optional>
#include <vector>

#include "mapping/base/median.h"

namespace waymark::mapping {

Eigen::Vector3d EstimateUp(std::span<const GeoSample> samples) {
  constexpr int kIterations = 10;
  constexpr double kScaleRad = 0.05;  // Cauchy
  std::optional<Eigen::Vector3d> up;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const GeoSample& sample : samples) {
      if (!sample.up_in_camera) continue;
      const Eigen::Vector3d one = sample.UpInModel();
      const double off = up ? up->cross(one).norm() / kScaleRad : 0;
      sum += one / (1 + off * off);
    }
    if (!(sum.norm() > 0)) break;
    up = sum.normalized();
  }
  if (up) return *up;
  // Minimise sum (x . up)^2 + m |up + mean y|^2: when all x axes agree, y decides what is left.
  constexpr double kYWeight = 0.05;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  for (const GeoSample& sample : samples) {
    const Eigen::Vector3d x = sample.XAxisInModel();
    spread += x * x.transpose() / static_cast<double>(samples.size());
    y += sample.model_from_camera.rotation() * Eigen::Vector3d::UnitY();
  }
  if (!(y.norm() > 1e-9)) return Eigen::Vector3d::UnitZ();
  spread.diagonal().array() += kYWeight;
  return spread.ldlt().solve(-y).normalized();
}

double EstimateGravitySigma(std::span<const GeoSample> samples, const Eigen::Vector3d& up_in_model,
                            double stated_sigma_rad) {
  constexpr double kDoubt = 3;
  std::vector<double> angles;
  for (const GeoSample& sample : samples) {
    if (!sample.up_in_camera) continue;
    const Eigen::Vector3d one = sample.UpInModel();
    angles.push_back(std::atan2(up_in_model.cross(one).norm(), up_in_model.dot(one)));
  }
  if (angles.empty()) return stated_sigma_rad;
  const double sigma = Median(angles) / 1.177;  // the median length of two normal components
  if (sigma <= 2 * stated_sigma_rad) return stated_sigma_rad;
  return kDoubt * sigma * std::sqrt(static_cast<double>(angles.size()));
}

Eigen::Quaterniond UprightRotation(const Eigen::Vector3d& up_in_model) {
  return Eigen::Quaterniond::FromTwoVectors(up_in_model, Eigen::Vector3d::UnitZ());
}

}  // namespace waymark::mapping

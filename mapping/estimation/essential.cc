// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/essential.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <array>
#include <cmath>

#include "mapping/estimation/projection_derivatives.h"

namespace waymark::mapping {
namespace {

double NormalizedPerPixel(const CameraModel& camera, const Eigen::Vector2d& normalized) {
  const double area = ProjectWithDerivatives(camera.kind(), camera.parameters().data(), normalized)
                          .by_normalized.determinant();
  return 1 / std::sqrt(std::max(std::abs(area), 1.0));
}

// Two directions that complete a unit vector to a right-handed basis.
Eigen::Matrix<double, 3, 2> TangentBasis(const Eigen::Vector3d& unit) {
  Eigen::Index smallest;
  unit.cwiseAbs().minCoeff(&smallest);
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = unit.cross(Eigen::Vector3d::Unit(smallest)).normalized();
  basis.col(1) = unit.cross(basis.col(0));
  return basis;
}

// Sampson's denominator: the variance of x1^T E x2 for a pixel sigma of 1.
double ResidualVariance(const Eigen::Matrix3d& essential, const NormalizedMatch& match) {
  const Eigen::Vector2d line1 = (essential * match.second.homogeneous()).head<2>();
  const Eigen::Vector2d line2 = (essential.transpose() * match.first.homogeneous()).head<2>();
  return line1.squaredNorm() * match.first_per_px * match.first_per_px +
         line2.squaredNorm() * match.second_per_px * match.second_per_px;
}

}  // namespace

std::vector<NormalizedMatch> NormalizeMatches(const CameraModel& first, const CameraModel& second,
                                              std::span<const Eigen::Vector2d> first_px,
                                              std::span<const Eigen::Vector2d> second_px) {
  CHECK(first_px.size() == second_px.size());
  std::vector<NormalizedMatch> matches;
  matches.reserve(first_px.size());
  for (std::size_t i = 0; i < first_px.size(); ++i) {
    const Eigen::Vector2d a = first.Normalize(first_px[i]);
    const Eigen::Vector2d b = second.Normalize(second_px[i]);
    matches.push_back({a, b, NormalizedPerPixel(first, a), NormalizedPerPixel(second, b)});
  }
  return matches;
}

double SquaredSampsonErrorPx(const Eigen::Matrix3d& essential, const NormalizedMatch& match) {
  const double residual = match.first.homogeneous().dot(essential * match.second.homogeneous());
  const double variance = ResidualVariance(essential, match);
  return variance > 0 ? residual * residual / variance : 1e300;
}

Eigen::Matrix3d EssentialFromPose(const Rigid3& first_from_second) {
  return CrossMatrix(first_from_second.translation()) *
         first_from_second.rotation().toRotationMatrix();
}

std::optional<Rigid3> PoseFromEssential(const Eigen::Matrix3d& essential,
                                        std::span<const NormalizedMatch> matches,
                                        std::span<const std::uint32_t> chosen) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()(1) > 1e-6 * svd.singularValues()(0))) return std::nullopt;
  Eigen::Matrix3d u = svd.matrixU();
  Eigen::Matrix3d v = svd.matrixV();
  if (u.determinant() < 0) u.col(2) *= -1;
  if (v.determinant() < 0) v.col(2) *= -1;
  Eigen::Matrix3d quarter_turn;
  quarter_turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  std::optional<Rigid3> best;
  int best_count = -1;
  for (const Eigen::Matrix3d& turn : {quarter_turn, Eigen::Matrix3d(quarter_turn.transpose())}) {
    for (const double sign : {1.0, -1.0}) {
      const Rigid3 pose(Eigen::Quaterniond(u * turn * v.transpose()), sign * u.col(2));
      int count = 0;
      for (std::uint32_t i : chosen) {
        const auto depths = TriangulatedDepths(pose, matches[i]);
        if (depths && depths->x() > 0 && depths->y() > 0) ++count;
      }
      if (count <= best_count) continue;
      best_count = count;
      best = pose;
    }
  }
  return best;
}

std::optional<Eigen::Vector2d> TriangulatedDepths(const Rigid3& first_from_second,
                                                  const NormalizedMatch& match) {
  // Normal equations of depth1 * a - depth2 * b = t.
  const Eigen::Vector3d a = match.first.homogeneous();
  const Eigen::Vector3d b = first_from_second.rotation() * match.second.homogeneous();
  const Eigen::Vector3d& t = first_from_second.translation();
  const double aa = a.squaredNorm();
  const double bb = b.squaredNorm();
  const double ab = a.dot(b);
  const double determinant = aa * bb - ab * ab;
  if (!(determinant > 1e-14 * aa * bb)) return std::nullopt;
  const double at = a.dot(t);
  const double bt = b.dot(t);
  return Eigen::Vector2d((bb * at - ab * bt) / determinant, (ab * at - aa * bt) / determinant);
}

double RayAngle(const Rigid3& first_from_second, const NormalizedMatch& match) {
  const Eigen::Vector3d a = match.first.homogeneous();
  const Eigen::Vector3d b = first_from_second.rotation() * match.second.homogeneous();
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Rigid3 RefineRelativePose(const Rigid3& first_from_second, std::span<const NormalizedMatch> matches,
                          std::span<const std::uint32_t> chosen, double huber_px) {
  using Vector5d = Eigen::Matrix<double, 5, 1>;
  constexpr int kIterations = 6;
  Rigid3 pose(first_from_second.rotation(), first_from_second.translation().normalized());
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::Matrix3d rotation = pose.rotation().toRotationMatrix();
    const Eigen::Vector3d t = pose.translation();
    const Eigen::Matrix3d essential = CrossMatrix(t) * rotation;
    const Eigen::Matrix<double, 3, 2> basis = TangentBasis(t);
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    Vector5d gradient = Vector5d::Zero();
    for (std::uint32_t i : chosen) {
      const Eigen::Vector3d a = matches[i].first.homogeneous();
      const Eigen::Vector3d b = rotation * matches[i].second.homogeneous();
      const double variance = ResidualVariance(essential, matches[i]);
      if (!(variance > 0)) continue;
      const double residual = a.dot(t.cross(b)) / std::sqrt(variance);
      const double huber = std::abs(residual) <= huber_px ? 1 : huber_px / std::abs(residual);
      // a . (t x b) moves by dt . (b x a) and, with b -> b + dr x b, by dr . (b x (a x t)).
      Vector5d jacobian;
      jacobian << basis.transpose() * b.cross(a), b.cross(a.cross(t));
      jacobian /= std::sqrt(variance);  // the denominator is held during a step
      normal.noalias() += huber * jacobian * jacobian.transpose();
      gradient += huber * residual * jacobian;
    }
    normal.diagonal() *= 1 + 1e-9;
    const Vector5d step = normal.ldlt().solve(-gradient);
    if (!step.allFinite()) break;
    pose = Rigid3(RotationFromVector(step.tail<3>()) * pose.rotation(),
                  (t + basis * step.head<2>()).normalized());
    if (step.squaredNorm() < 1e-18) break;
  }
  return pose;
}

}  // namespace waymark::mapping

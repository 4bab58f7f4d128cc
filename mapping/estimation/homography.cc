// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/homography.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <cmath>

#include "mapping/estimation/robust_loop.h"

namespace waymark::mapping {
namespace {

// The direct linear transform over some matches: H maps second to first. Normalised coordinates
// are of order one, so that no further conditioning is needed.
std::optional<Eigen::Matrix3d> SolveHomography(std::span<const NormalizedMatch> matches,
                                               std::span<const std::uint32_t> chosen) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::uint32_t i : chosen) {
    const Eigen::RowVector3d b = matches[i].second.homogeneous().transpose();
    Eigen::Matrix<double, 2, 9> rows;
    rows << b, Eigen::RowVector3d::Zero(), -matches[i].first.x() * b,  //
        Eigen::RowVector3d::Zero(), b, -matches[i].first.y() * b;
    normal.noalias() += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(normal);
  if (eigen.info() != Eigen::Success) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> h = eigen.eigenvectors().col(0);
  Eigen::Matrix3d homography;
  homography << h.head<3>().transpose(), h.segment<3>(3).transpose(), h.tail<3>().transpose();
  return homography;
}

class HomographyFromMatches {
 public:
  using Model = Eigen::Matrix3d;
  static constexpr std::size_t kSampleSize = 4;

  HomographyFromMatches(std::span<const NormalizedMatch> matches,
                        std::span<const std::uint32_t> chosen, double max_error_px)
      : max_error_px_(max_error_px) {
    for (std::uint32_t i : chosen) matches_.push_back(matches[i]);
  }

  std::size_t size() const { return matches_.size(); }

  void Solve(std::span<const std::uint32_t> sample, std::vector<Model>& models) const {
    if (const auto homography = SolveHomography(matches_, sample)) models.push_back(*homography);
  }

  double Cost(const Model& homography, double limit) const {
    double cost = 0;
    for (std::size_t i = 0; i < size() && cost <= limit; ++i) {
      cost += std::min(SquaredError(homography, i), 1.0);
    }
    return cost;
  }

  void CollectInliers(const Model& homography, double bound,
                      std::vector<std::uint32_t>& inliers) const {
    inliers.clear();
    for (std::size_t i = 0; i < size(); ++i) {
      if (SquaredError(homography, i) < bound) inliers.push_back(static_cast<std::uint32_t>(i));
    }
  }

  std::optional<Model> Refine(const Model& /*start*/,
                              std::span<const std::uint32_t> inliers) const {
    return SolveHomography(matches_, inliers);
  }

 private:
  double SquaredError(const Model& homography, std::size_t i) const {
    const Eigen::Vector3d mapped = homography * matches_[i].second.homogeneous();
    const Eigen::Vector2d error = mapped.hnormalized() - matches_[i].first;
    const double unit = max_error_px_ * matches_[i].first_per_px;
    const double squared = error.squaredNorm() / (unit * unit);
    return squared < 1e9 ? squared : 1e9;  // also for not-a-number
  }

  std::vector<NormalizedMatch> matches_;
  double max_error_px_;
};

double SquaredRotationErrorPx(const Eigen::Quaterniond& first_from_second,
                              const NormalizedMatch& match) {
  const Eigen::Vector3d turned = first_from_second * match.second.homogeneous();
  if (!(turned.z() > 1e-9)) return 1e300;
  return (turned.hnormalized() - match.first).squaredNorm() /
         (match.first_per_px * match.first_per_px);
}

}  // namespace

std::size_t CountHomographyInliers(std::span<const NormalizedMatch> matches,
                                   std::span<const std::uint32_t> chosen, double max_error_px,
                                   std::uint64_t seed) {
  const HomographyFromMatches problem(matches, chosen, max_error_px);
  const auto fit = RunRobustLoop(
      problem, {}, {.min_inliers = 4, .confidence = 0.99, .max_iterations = 100, .seed = seed});
  return fit ? fit->inliers.size() : 0;
}

Eigen::Quaterniond EstimateRotation(std::span<const NormalizedMatch> matches,
                                    std::span<const std::uint32_t> chosen, double max_error_px) {
  constexpr int kIterations = 5;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::uint32_t i : chosen) {
      double weight = 1;
      if (iteration > 0) {
        const double squared = SquaredRotationErrorPx(rotation, matches[i]);
        weight = 1 / (1 + squared / (max_error_px * max_error_px));  // Cauchy
      }
      covariance += weight * matches[i].first.homogeneous().normalized() *
                    matches[i].second.homogeneous().normalized().transpose();
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d sign(1, 1, svd.matrixU().determinant() * svd.matrixV().determinant());
    rotation = Eigen::Quaterniond(
        Eigen::Matrix3d(svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose()));
  }
  return rotation;
}

std::vector<std::uint32_t> RotationInliers(std::span<const NormalizedMatch> matches,
                                           const Eigen::Quaterniond& first_from_second,
                                           double max_error_px) {
  std::vector<std::uint32_t> inliers;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (SquaredRotationErrorPx(first_from_second, matches[i]) < max_error_px * max_error_px) {
      inliers.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return inliers;
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/burst/problem.h"

#include <Eigen/Geometry>

#include <algorithm>

#include "mapping/estimation/projection_derivatives.h"

namespace waymark::localiser::internal {

BurstProblem::BurstProblem(std::span<const BurstCamera> cameras, const ImageMatches& matches,
                           const Eigen::Vector3d& up_in_submap, double max_error_px)
    : cameras_(cameras),
      matches_(matches),
      max_error_px_(max_error_px),
      submap_from_upright_(
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up_in_submap)) {
  for (const BurstCamera& taken : cameras) {
    views_.push_back({taken.vo_from_camera.rotation().toRotationMatrix().transpose(),
                      taken.vo_from_camera.translation(),
                      {}});
  }
  for (const Eigen::Vector3d& point : matches.points_in_submap) centre_ += point;
  centre_ /= static_cast<double>(std::max<std::size_t>(1, size()));
  for (std::size_t i = 0; i < size(); ++i) AddMatch(i);
  for (View& view : views_) view.table.Pad();
}

void BurstProblem::AddMatch(std::size_t i) {
  const BurstCamera& taken = cameras_[matches_.images[i]];
  const Eigen::Vector3d& point = matches_.points_in_submap[i];
  const Eigen::Vector2d uv = taken.camera.Normalize(matches_.pixels_px[i]);
  rays_.push_back({taken.vo_from_camera.translation(),
                   taken.vo_from_camera.rotation() * uv.homogeneous().normalized()});
  points_in_upright_.push_back(submap_from_upright_.conjugate() * point);
  const Eigen::Matrix2d stretch =
      mapping::ProjectWithDerivatives(taken.camera.kind(), taken.camera.parameters().data(), uv)
          .by_normalized /
      max_error_px_;
  const Eigen::Vector3f p = (point - centre_).cast<float>();
  views_[matches_.images[i]].table.Add(
      p.x(), p.y(), p.z(), static_cast<float>(uv.x()), static_cast<float>(uv.y()),
      static_cast<float>(stretch.col(0).norm()), static_cast<float>(stretch.col(1).norm()));
}

void BurstProblem::Solve(std::span<const std::uint32_t> sample, std::vector<Rigid3>& models) const {
  const std::size_t known = models.size();
  mapping::SolveUprightRig({rays_[sample[0]], rays_[sample[1]]},
                           {points_in_upright_[sample[0]], points_in_upright_[sample[1]]}, models);
  const Rigid3 submap_from_upright(submap_from_upright_, Eigen::Vector3d::Zero());
  for (std::size_t i = known; i < models.size(); ++i) models[i] = submap_from_upright * models[i];
}

double BurstProblem::Cost(const Rigid3& submap_from_vo, double limit) const {
  const Eigen::Matrix3d vo_from_submap = submap_from_vo.rotation().toRotationMatrix().transpose();
  const Eigen::Vector3d centre_in_vo = vo_from_submap * (centre_ - submap_from_vo.translation());
  double cost = 0;
  for (const View& view : views_) {
    if (cost > limit) break;
    const Eigen::Matrix3d rotation = view.camera_from_vo * vo_from_submap;
    const Eigen::Vector3d translation = view.camera_from_vo * (centre_in_vo - view.centre_in_vo);
    float pose[12];
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        pose[4 * row + column] = static_cast<float>(rotation(row, column));
      }
      pose[4 * row + 3] = static_cast<float>(translation(row));
    }
    cost += static_cast<double>(view.table.TruncatedCost(pose));
  }
  return cost;
}

void BurstProblem::CollectInliers(const BurstState& state, double bound,
                                  std::vector<std::uint32_t>& inliers) const {
  inliers.clear();
  for (std::uint32_t i = 0; i < size(); ++i) {
    const auto residual_px = BurstResidualPx(cameras_, matches_, i, state);
    if (residual_px && residual_px->squaredNorm() < bound * max_error_px_ * max_error_px_) {
      inliers.push_back(i);
    }
  }
}

std::optional<Rigid3> BurstProblem::Refine(const Rigid3& submap_from_vo,
                                           std::span<const std::uint32_t> inliers) const {
  const auto refined = RefineBurst(cameras_, matches_, inliers, {submap_from_vo},
                                   {.huber_px = max_error_px_ / 2, .max_iterations = 5});
  if (!refined) return std::nullopt;
  return refined->state.submap_from_vo;
}

}  // namespace waymark::localiser::internal

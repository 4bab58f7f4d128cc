// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <opengv/absolute_pose/modules/main.hpp>
#include <optional>
#include <span>
#include <vector>

#include "mapping/estimation/pose_refinement.h"
#include "mapping/estimation/projection_derivatives.h"
#include "mapping/estimation/reprojection_table.h"
#include "mapping/estimation/upright_pose.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping::internal {

/// The robust loop's view of the problem. Scores are approximate (the lens is linearised at each
/// pixel, single precision); inliers and refinement use the exact camera.
class PoseFromMatches {
 public:
  using Model = Rigid3;  // world_from_camera
  static constexpr std::size_t kSampleSize = 3;

  PoseFromMatches(const CameraModel& camera, std::span<const Eigen::Vector2d> pixels_px,
                  std::span<const Eigen::Vector3d> points_in_world, double max_error_px)
      : camera_(camera),
        pixels_px_(pixels_px),
        points_in_world_(points_in_world),
        max_error_px_(max_error_px),
        sample_bearings_(kSampleSize),
        sample_points_(kSampleSize) {
    for (const Eigen::Vector3d& point : points_in_world) centre_ += point;
    centre_ /= static_cast<double>(points_in_world.size());
    bearings_.reserve(pixels_px.size());
    for (std::size_t i = 0; i < pixels_px.size(); ++i) {
      const Eigen::Vector2d uv = camera.Normalize(pixels_px[i]);
      bearings_.push_back(uv.homogeneous().normalized());
      const Eigen::Matrix2d stretch =
          ProjectWithDerivatives(camera.kind(), camera.parameters().data(), uv).by_normalized /
          max_error_px;
      const Eigen::Vector3f p = (points_in_world[i] - centre_).cast<float>();
      table_.Add(p.x(), p.y(), p.z(), static_cast<float>(uv.x()), static_cast<float>(uv.y()),
                 static_cast<float>(stretch.col(0).norm()),
                 static_cast<float>(stretch.col(1).norm()));
    }
    table_.Pad();
  }

  std::size_t size() const { return pixels_px_.size(); }

  void Solve(std::span<const std::uint32_t> sample, std::vector<Rigid3>& models) const {
    for (std::size_t k = 0; k < kSampleSize; ++k) {
      sample_bearings_[k] = bearings_[sample[k]];
      sample_points_[k] = points_in_world_[sample[k]];
    }
    // Three points on a line, or two in one place, determine nothing.
    const Eigen::Vector3d a = sample_points_[1] - sample_points_[0];
    const Eigen::Vector3d b = sample_points_[2] - sample_points_[0];
    if (!(a.cross(b).squaredNorm() > 1e-12 * a.squaredNorm() * b.squaredNorm())) return;
    solutions_.clear();
    opengv::absolute_pose::modules::p3p_kneip_main(sample_bearings_, sample_points_, solutions_);
    for (const auto& world_from_camera : solutions_) {
      if (!world_from_camera.allFinite()) continue;
      const Rigid3 model(Eigen::Quaterniond(world_from_camera.leftCols<3>()),
                         world_from_camera.col(3));
      models.push_back(model);
    }
  }

  double Cost(const Rigid3& world_from_camera, double /*limit*/) const {
    const Eigen::Matrix3d rotation = world_from_camera.rotation().toRotationMatrix().transpose();
    const Eigen::Vector3d translation = rotation * (centre_ - world_from_camera.translation());
    float pose[12];
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        pose[4 * row + column] = static_cast<float>(rotation(row, column));
      }
      pose[4 * row + 3] = static_cast<float>(translation(row));
    }
    return static_cast<double>(table_.TruncatedCost(pose));
  }

  void CollectInliers(const Rigid3& world_from_camera, double bound,
                      std::vector<std::uint32_t>& inliers) const {
    CollectInliers(camera_, world_from_camera, bound, inliers);
  }

  void CollectInliers(const CameraModel& camera, const Rigid3& world_from_camera, double bound,
                      std::vector<std::uint32_t>& inliers) const {
    inliers.clear();
    const Rigid3 camera_from_world = world_from_camera.Inverse();
    const double max_squared = bound * max_error_px_ * max_error_px_;
    for (std::size_t i = 0; i < size(); ++i) {
      const auto pixel_px = camera.Project(camera_from_world * points_in_world_[i]);
      if (pixel_px && (*pixel_px - pixels_px_[i]).squaredNorm() < max_squared) {
        inliers.push_back(static_cast<std::uint32_t>(i));
      }
    }
  }

  std::optional<Rigid3> Refine(const Rigid3& model, std::span<const std::uint32_t> inliers) const {
    const auto refined = RefinePose(camera_, pixels_px_, points_in_world_, inliers, model,
                                    {.huber_px = max_error_px_ / 2, .max_iterations = 5});
    if (!refined) return std::nullopt;
    return refined->world_from_camera;
  }

 protected:
  const opengv::bearingVectors_t& bearings() const { return bearings_; }
  std::span<const Eigen::Vector3d> points_in_world() const { return points_in_world_; }

 private:
  const CameraModel& camera_;
  std::span<const Eigen::Vector2d> pixels_px_;
  std::span<const Eigen::Vector3d> points_in_world_;
  double max_error_px_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  opengv::bearingVectors_t bearings_;
  ReprojectionTable table_;
  // Scratch of Solve, to allocate once.
  mutable opengv::bearingVectors_t sample_bearings_;
  mutable opengv::points_t sample_points_;
  mutable opengv::transformations_t solutions_;
};

/// The same where gravity is known: two matches are a sample. Only samples obey it exactly;
/// refinement turns the camera as the matches say.
class UprightPoseFromMatches : public PoseFromMatches {
 public:
  static constexpr std::size_t kSampleSize = 2;

  UprightPoseFromMatches(const CameraModel& camera, std::span<const Eigen::Vector2d> pixels_px,
                         std::span<const Eigen::Vector3d> points_in_world, double max_error_px,
                         const SharedUp& up)
      : PoseFromMatches(camera, pixels_px, points_in_world, max_error_px), solver_(up) {}

  void Solve(std::span<const std::uint32_t> sample, std::vector<Rigid3>& models) const {
    solver_.Solve({bearings()[sample[0]], bearings()[sample[1]]},
                  {points_in_world()[sample[0]], points_in_world()[sample[1]]}, models);
  }

 private:
  UprightPoseSolver solver_;
};

}  // namespace waymark::mapping::internal

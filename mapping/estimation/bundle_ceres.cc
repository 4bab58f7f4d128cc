// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/internal/bundle_ceres.h"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <omp.h>

#include <algorithm>
#include <memory>

#include "mapping/estimation/internal/bundle_costs.h"
#include "mapping/estimation/internal/bundle_terms.h"

namespace waymark::mapping {
namespace {

using internal::kPoseSize;
constexpr std::size_t kMaxIntrinsics = 8;

// One adjustment: the parameter arrays, the Ceres problem over them, and the way back.
class Adjustment {
 public:
  Adjustment(BundleProblem& bundle, const BundleOptions& options)
      : bundle_(bundle), options_(options), problem_(ProblemOptions()) {
    if (options.loss == ObservationLoss::kHuber) {
      observation_loss_ = std::make_unique<ceres::HuberLoss>(options.loss_scale);
    } else if (options.loss == ObservationLoss::kCauchy) {
      observation_loss_ = std::make_unique<ceres::CauchyLoss>(options.loss_scale);
    }
    ReadParameters();
    AddObservations();
    AddPosePriors();
    AddRigLinks();
    AddIntrinsics();
  }

  BundleSummary Solve() {
    ceres::Solver::Options solver;
    std::size_t free_poses = 0;
    for (std::size_t i = 0; i < bundle_.poses.size(); ++i) {
      free_poses += pose_is_used_[i] && !bundle_.poses[i].hold ? 1 : 0;
    }
    constexpr std::size_t kDenseUpTo = 60;
    solver.linear_solver_type = free_poses <= kDenseUpTo ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    solver.linear_solver_ordering = Ordering();
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = options_.relative_tolerance;
    // More than the machine has would make Ceres complain on standard error.
    const std::size_t cores = Parallelism{0}.ThreadCount();
    solver.num_threads = static_cast<int>(std::min(options_.parallelism.ThreadCount(), cores));
    solver.logging_type = ceres::SILENT;
    // Our threads are enough: the sparse solver would start a spinning team in each of them.
    omp_set_num_threads(1);
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    usable_ = summary.IsSolutionUsable();
    message_ = summary.message;
    return {.initial_cost = summary.initial_cost,
            .final_cost = summary.final_cost,
            .iterations = static_cast<int>(summary.iterations.size()),
            .converged = summary.termination_type == ceres::CONVERGENCE};
  }

  bool usable() const { return usable_; }
  const std::string& message() const { return message_; }

  // Errors: Unavailable when an intrinsic became impossible.
  Result<void> WriteBack() {
    for (std::size_t k = 0; k < bundle_.cameras.size(); ++k) {
      CameraModel& model = bundle_.cameras[k].model;
      auto refined = CameraModel::Create(model.kind(), model.width_px(), model.height_px(),
                                         std::span(CameraBlock(k), ParameterCount(model.kind())));
      if (!refined) {
        return MakeError(ErrorCode::kUnavailable, "bundle: camera {} diverged: {}", k,
                         refined.error().message);
      }
      model = *refined;
    }
    for (std::size_t i = 0; i < bundle_.poses.size(); ++i) {
      const double* p = PoseBlock(i);
      bundle_.poses[i].world_from_camera =
          Rigid3(Eigen::Quaterniond(p[3], p[0], p[1], p[2]), Eigen::Vector3d(p[4], p[5], p[6]));
    }
    return {};
  }

 private:
  static ceres::Problem::Options ProblemOptions() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  // All in one array, poses first: Ceres orders blocks by address, and the order of arithmetic must
  // not depend on where memory happens to be.
  double* PoseBlock(std::size_t i) { return &blocks_[kPoseSize * i]; }
  double* CameraBlock(std::size_t k) {
    return &blocks_[kPoseSize * bundle_.poses.size() + kMaxIntrinsics * k];
  }

  void ReadParameters() {
    blocks_.resize(kPoseSize * bundle_.poses.size() + kMaxIntrinsics * bundle_.cameras.size());
    for (std::size_t i = 0; i < bundle_.poses.size(); ++i) {
      Eigen::Map<Eigen::Matrix<double, kPoseSize, 1>> block(PoseBlock(i));
      block << bundle_.poses[i].world_from_camera.rotation().coeffs(),
          bundle_.poses[i].world_from_camera.translation();
    }
    for (std::size_t k = 0; k < bundle_.cameras.size(); ++k) {
      const auto parameters = bundle_.cameras[k].model.parameters();
      std::copy(parameters.begin(), parameters.end(), CameraBlock(k));
    }
    pose_is_used_.assign(bundle_.poses.size(), false);
    camera_is_used_.assign(bundle_.cameras.size(), false);
    point_is_used_.assign(bundle_.points_in_world.size(), false);
  }

  void AddObservations() {
    for (const BundleObservation& observation : bundle_.observations) {
      const std::uint32_t camera = bundle_.poses[observation.pose].camera;
      auto* cost = new internal::ReprojectionCost(bundle_.cameras[camera].model.kind(),
                                                  observation.pixel_px, options_.pixel_sigma_px);
      problem_.AddResidualBlock(cost, observation_loss_.get(), PoseBlock(observation.pose),
                                bundle_.points_in_world[observation.point].data(),
                                CameraBlock(camera));
      pose_is_used_[observation.pose] = true;
      point_is_used_[observation.point] = true;
      camera_is_used_[camera] = true;
    }
  }

  void AddPosePriors() {
    for (std::size_t i = 0; i < bundle_.poses.size(); ++i) {
      if (!pose_is_used_[i]) continue;
      const BundlePose& pose = bundle_.poses[i];
      double* block = PoseBlock(i);
      problem_.SetManifold(block, &manifold_);
      if (pose.hold) {
        problem_.SetParameterBlockConstant(block);
        continue;
      }
      if (pose.position_prior) {
        problem_.AddResidualBlock(
            new internal::PositionCost(*pose.position_prior, pose.position_sigma_m),
            &position_loss_, block);
      }
      if (pose.up_in_camera) {
        problem_.AddResidualBlock(
            new internal::UpCost(*pose.up_in_camera, options_.gravity_sigma_rad), &gravity_loss_,
            block);
      }
      if (pose.is_level) {
        problem_.AddResidualBlock(new internal::LevelCost(options_.level_sigma_rad), &gravity_loss_,
                                  block);
      }
    }
  }

  void AddRigLinks() {
    for (const BundleRigLink& link : bundle_.rig_links) {
      if (!pose_is_used_[link.pose] || !pose_is_used_[link.before] || !pose_is_used_[link.after]) {
        continue;
      }
      problem_.AddResidualBlock(
          new internal::RigCost(link.share, link.offset_in_camera, link.sigma_m), &position_loss_,
          PoseBlock(link.pose), PoseBlock(link.before), PoseBlock(link.after));
    }
  }

  void AddIntrinsics() {
    for (std::size_t k = 0; k < bundle_.cameras.size(); ++k) {
      if (!camera_is_used_[k]) continue;
      const BundleCamera& camera = bundle_.cameras[k];
      const CameraKind kind = camera.model.kind();
      const auto count = static_cast<int>(ParameterCount(kind));
      double* block = CameraBlock(k);
      if (camera.hold) {
        problem_.SetParameterBlockConstant(block);
        continue;
      }
      const bool two_focals = kind == CameraKind::kPinhole || kind == CameraKind::kOpenCv;
      const int centre = two_focals ? 2 : 1;
      std::vector<int> held;
      for (int p = 0; p < count; ++p) {
        if (internal::NeverMoves(kind, p)) held.push_back(p);
      }
      subsets_.push_back(std::make_unique<ceres::SubsetManifold>(count, std::move(held)));
      problem_.SetManifold(block, subsets_.back().get());
      Eigen::VectorXd initial = Eigen::VectorXd::Ones(count);
      Eigen::VectorXd weights = Eigen::VectorXd::Zero(count);
      for (int p = 0; p < count; ++p) {
        initial(p) = camera.initial.parameters()[static_cast<std::size_t>(p)];
        if (p < centre) weights(p) = 1 / (camera.focal_sigma_share * initial(p));
        if (p >= centre + 2) weights(p) = 1 / camera.lens_sigma;
      }
      const double aspect_weight = two_focals ? 1 / camera.aspect_sigma : 0;
      problem_.AddResidualBlock(new internal::IntrinsicsCost(initial, weights, aspect_weight),
                                nullptr, block);
    }
  }

  std::shared_ptr<ceres::ParameterBlockOrdering> Ordering() {
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (std::size_t i = 0; i < point_is_used_.size(); ++i) {
      if (point_is_used_[i]) {
        ordering->AddElementToGroup(bundle_.points_in_world[i].data(), 0);
      }
    }
    for (std::size_t i = 0; i < bundle_.poses.size(); ++i) {
      if (pose_is_used_[i]) ordering->AddElementToGroup(PoseBlock(i), 1);
    }
    for (std::size_t k = 0; k < bundle_.cameras.size(); ++k) {
      if (camera_is_used_[k]) ordering->AddElementToGroup(CameraBlock(k), 1);
    }
    return ordering;
  }

  BundleProblem& bundle_;
  const BundleOptions& options_;
  std::vector<double> blocks_;
  std::vector<bool> pose_is_used_, camera_is_used_, point_is_used_;
  internal::PerturbManifold manifold_;
  std::vector<std::unique_ptr<ceres::SubsetManifold>> subsets_;
  std::unique_ptr<ceres::LossFunction> observation_loss_;
  ceres::CauchyLoss position_loss_{options_.position_scale};
  ceres::CauchyLoss gravity_loss_{2};
  ceres::Problem problem_;  // last: destroyed before what it refers to
  bool usable_ = false;
  std::string message_;
};

}  // namespace

namespace internal {

Result<BundleSummary> AdjustBundleWithCeres(BundleProblem& problem, const BundleOptions& options) {
  Adjustment adjustment(problem, options);
  const BundleSummary summary = adjustment.Solve();
  if (!adjustment.usable()) {
    return MakeError(ErrorCode::kUnavailable, "bundle: {} poses, {} points: {}",
                     problem.poses.size(), problem.points_in_world.size(), adjustment.message());
  }
  WAYMARK_TRY(adjustment.WriteBack());
  return summary;
}

}  // namespace internal
}  // namespace waymark::mapping

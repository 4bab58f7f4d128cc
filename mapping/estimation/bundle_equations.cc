// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/internal/bundle_equations.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace waymark::mapping::internal {
namespace {

constexpr double kGravityScale = 2;  // sigmas, of the Cauchy loss of gravity and level axes

std::vector<ReadyPose> ReadyPoses(std::span<const Rigid3> poses) {
  return {poses.begin(), poses.end()};
}

}  // namespace

BundleEquations::BundleEquations(const BundleProblem& bundle, const BundleOptions& options)
    : bundle_(bundle),
      options_(options),
      layout_(bundle),
      reduced_(layout_.block_sizes, layout_.pattern) {}

std::vector<BundleEquations::Prior> BundleEquations::Priors(const BundleState& state) const {
  std::vector<Prior> priors;
  for (std::size_t i = 0; i < bundle_.poses.size(); ++i) {
    if (layout_.pose_blocks[i] < 0) continue;
    const BundlePose& pose = bundle_.poses[i];
    const auto add = [&](double scale, const auto& term) {
      priors.push_back({scale, term.residual, {{layout_.pose_blocks[i], term.by_pose}}});
    };
    if (pose.position_prior) {
      add(options_.position_scale,
          PositionTerm(state.poses[i], *pose.position_prior, pose.position_sigma_m));
    }
    if (pose.up_in_camera) {
      add(kGravityScale, UpTerm(state.poses[i], *pose.up_in_camera, options_.gravity_sigma_rad));
    }
    if (pose.is_level) add(kGravityScale, LevelTerm(state.poses[i], options_.level_sigma_rad));
  }
  for (const BundleRigLink& link : bundle_.rig_links) {
    if (!layout_.pose_is_used[link.pose] || !layout_.pose_is_used[link.before] ||
        !layout_.pose_is_used[link.after]) {
      continue;
    }
    const RigTerm term =
        LinkTerm(link, state.poses[link.pose], state.poses[link.before], state.poses[link.after]);
    priors.push_back({options_.position_scale,
                      term.residual,
                      {{layout_.pose_blocks[link.pose], term.by_pose},
                       {layout_.pose_blocks[link.before], term.by_before},
                       {layout_.pose_blocks[link.after], term.by_after}}});
  }
  for (std::size_t k = 0; k < bundle_.cameras.size(); ++k) {
    if (layout_.camera_blocks[k] < 0) continue;
    const IntrinsicsTerm term = PriorOfIntrinsics(bundle_.cameras[k], state.cameras[k].data());
    Eigen::MatrixXd by_free(9, layout_.free_parameters[k].size());
    for (std::size_t p = 0; p < layout_.free_parameters[k].size(); ++p) {
      by_free.col(static_cast<Eigen::Index>(p)) =
          term.by_parameters.col(layout_.free_parameters[k][p]);
    }
    priors.push_back({0, term.residual, {{layout_.camera_blocks[k], std::move(by_free)}}});
  }
  return priors;
}

double BundleEquations::PriorCost(std::span<const Prior> priors) const {
  double cost = 0;
  for (const Prior& prior : priors) {
    const auto loss = prior.scale > 0 ? ObservationLoss::kCauchy : ObservationLoss::kSquared;
    cost += EvaluateLoss(loss, prior.scale, prior.residual.squaredNorm()).loss / 2;
  }
  return cost;
}

double BundleEquations::CostOfPart(const BundleState& state, std::span<const ReadyPose> poses,
                                   std::size_t part) const {
  double cost = 0;
  for (std::size_t p = layout_.part_begins[part]; p < layout_.part_begins[part + 1]; ++p) {
    for (std::size_t o = layout_.point_begins[p]; o < layout_.point_begins[p + 1]; ++o) {
      const auto& [pose, camera, pixel_px] = layout_.observations[o];
      const Eigen::Vector2d residual =
          ReprojectionResidual(bundle_.cameras[camera].model.kind(), state.cameras[camera].data(),
                               poses[pose], state.points[p], pixel_px, options_.pixel_sigma_px);
      cost += EvaluateLoss(options_.loss, options_.loss_scale, residual.squaredNorm()).loss / 2;
    }
  }
  return cost;
}

double BundleEquations::Cost(const BundleState& state) const {
  const std::vector<ReadyPose> poses = ReadyPoses(state.poses);
  std::vector<double> costs(layout_.part_count());
  ParallelFor(costs.size(), options_.parallelism,
              [&](std::size_t part) { costs[part] = CostOfPart(state, poses, part); });
  return std::accumulate(costs.begin(), costs.end(), PriorCost(Priors(state)));
}

double BundleEquations::LinearisePart(const BundleState& state, std::span<const ReadyPose> poses,
                                      std::size_t part) {
  double cost = 0;
  for (std::size_t p = layout_.part_begins[part]; p < layout_.part_begins[part + 1]; ++p) {
    for (std::size_t o = layout_.point_begins[p]; o < layout_.point_begins[p + 1]; ++o) {
      const auto& [pose, camera, pixel_px] = layout_.observations[o];
      const ReprojectionTerm term =
          LineariseReprojection(bundle_.cameras[camera].model.kind(), state.cameras[camera].data(),
                                poses[pose], state.points[p], pixel_px, options_.pixel_sigma_px);
      const LossValue loss =
          EvaluateLoss(options_.loss, options_.loss_scale, term.residual.squaredNorm());
      cost += loss.loss / 2;
      const double weight = std::sqrt(loss.slope);
      ObservationTerms& out = terms_[o];
      for (int row : {0, 1}) {
        out.residual[row] = weight * term.residual(row);
        for (int i : {0, 1, 2}) {
          out.by_point[row][i] = weight * term.by_point(row, i);
          out.by_rotation[row][i] = weight * term.by_rotation(row, i);
        }
        for (std::size_t i = 0; i < kBlockSize; ++i) {
          out.by_camera[row][i] =
              i < layout_.free_parameters[camera].size()
                  ? weight * term.by_parameters(row, layout_.free_parameters[camera][i])
                  : 0;
        }
      }
    }
  }
  return cost;
}

double BundleEquations::Linearise(const BundleState& state) {
  terms_.resize(layout_.observations.size());
  const std::vector<ReadyPose> poses = ReadyPoses(state.poses);
  std::vector<double> costs(layout_.part_count());
  ParallelFor(costs.size(), options_.parallelism,
              [&](std::size_t part) { costs[part] = LinearisePart(state, poses, part); });
  priors_ = Priors(state);
  const double cost = std::accumulate(costs.begin(), costs.end(), PriorCost(priors_));
  for (Prior& prior : priors_) {
    if (prior.scale == 0) continue;
    const double weight = std::sqrt(
        EvaluateLoss(ObservationLoss::kCauchy, prior.scale, prior.residual.squaredNorm()).slope);
    prior.residual *= weight;
    for (ReducedEquations::Moved& moved : prior.moved) moved.derivative *= weight;
  }
  return cost;
}

PointObservations BundleEquations::Of(std::size_t point) const {
  const std::size_t begin = layout_.point_begins[point];
  const std::size_t count = layout_.point_begins[point + 1] - begin;
  return {std::span(terms_).subspan(begin, count), std::span(layout_.blocks).subspan(begin, count)};
}

void BundleEquations::MoveBlocks(std::span<const double> steps, Step& step) const {
  for (std::size_t i = 0; i < layout_.pose_blocks.size(); ++i) {
    if (layout_.pose_blocks[i] < 0) continue;
    const double* moved = &steps[kColumn * static_cast<std::size_t>(layout_.pose_blocks[i])];
    step.state.poses[i] =
        Perturb(step.state.poses[i], Eigen::Map<const Eigen::Matrix<double, 6, 1>>(moved));
  }
  for (std::size_t k = 0; k < layout_.camera_blocks.size(); ++k) {
    if (layout_.camera_blocks[k] < 0) continue;
    const double* moved = &steps[kColumn * static_cast<std::size_t>(layout_.camera_blocks[k])];
    for (std::size_t p = 0; p < layout_.free_parameters[k].size(); ++p) {
      step.state.cameras[k][static_cast<std::size_t>(layout_.free_parameters[k][p])] += moved[p];
    }
  }
  for (const Prior& prior : priors_) {
    Eigen::VectorXd change = Eigen::VectorXd::Zero(prior.residual.size());
    for (const ReducedEquations::Moved& moved : prior.moved) {
      if (moved.block < 0) continue;
      change += moved.derivative * Eigen::Map<const Eigen::VectorXd>(
                                       &steps[kColumn * static_cast<std::size_t>(moved.block)],
                                       moved.derivative.cols());
    }
    step.decrease -= change.dot(prior.residual + change / 2);
  }
}

std::optional<BundleEquations::Step> BundleEquations::Solve(const BundleState& state,
                                                            double damping) {
  const std::size_t parts = layout_.part_count();
  std::vector<BlockSums> sums(parts);
  ParallelFor(parts, options_.parallelism, [&](std::size_t part) {
    sums[part].Reset(layout_.pattern);
    PointEliminator eliminator(layout_.pattern);
    for (std::size_t p = layout_.part_begins[part]; p < layout_.part_begins[part + 1]; ++p) {
      if (layout_.point_begins[p] == layout_.point_begins[p + 1]) continue;
      eliminator.Eliminate(Of(p), damping, sums[part]);
    }
  });
  for (std::size_t part = 1; part < parts; ++part) sums[0].Add(sums[part]);
  for (const Prior& prior : priors_) reduced_.AddTerm(prior.residual, prior.moved, sums[0]);
  const auto steps = reduced_.Solve(sums[0], damping);
  if (!steps) return std::nullopt;

  Step step{.state = state};
  MoveBlocks(*steps, step);
  std::vector<double> decreases(parts, 0.0);
  ParallelFor(parts, options_.parallelism, [&](std::size_t part) {
    for (std::size_t p = layout_.part_begins[part]; p < layout_.part_begins[part + 1]; ++p) {
      if (layout_.point_begins[p] == layout_.point_begins[p + 1]) continue;
      double moved[3];
      decreases[part] += SolvePoint(Of(p), damping, *steps, moved);
      step.state.points[p] += Eigen::Vector3d(moved[0], moved[1], moved[2]);
    }
  });
  step.decrease = std::accumulate(decreases.begin(), decreases.end(), step.decrease);
  return step;
}

}  // namespace waymark::mapping::internal

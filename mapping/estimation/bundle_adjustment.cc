// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/estimation/internal/bundle_ceres.h"
#include "mapping/estimation/internal/bundle_equations.h"

namespace waymark::mapping {
namespace {

using internal::BundleEquations;
using internal::BundleState;

BundleState ReadState(const BundleProblem& problem) {
  BundleState state{.poses = {}, .cameras = {}, .points = problem.points_in_world};
  for (const BundlePose& pose : problem.poses) state.poses.push_back(pose.world_from_camera);
  for (const BundleCamera& camera : problem.cameras) {
    const auto parameters = camera.model.parameters();
    std::copy(parameters.begin(), parameters.end(), state.cameras.emplace_back().begin());
  }
  return state;
}

/// Errors: Unavailable when an intrinsic became impossible.
Result<void> WriteBack(BundleState state, BundleProblem& problem) {
  std::vector<CameraModel> cameras;
  for (std::size_t k = 0; k < problem.cameras.size(); ++k) {
    const CameraModel& model = problem.cameras[k].model;
    auto refined =
        CameraModel::Create(model.kind(), model.width_px(), model.height_px(),
                            std::span(state.cameras[k]).first(model.parameters().size()));
    if (!refined) {
      return MakeError(ErrorCode::kUnavailable, "bundle: camera {} diverged: {}", k,
                       refined.error().message);
    }
    cameras.push_back(*refined);
  }
  for (std::size_t k = 0; k < cameras.size(); ++k) problem.cameras[k].model = cameras[k];
  for (std::size_t i = 0; i < problem.poses.size(); ++i) {
    problem.poses[i].world_from_camera = state.poses[i];
  }
  problem.points_in_world = std::move(state.points);
  return {};
}

/// How far the linearised equations are trusted: the damping of their diagonal.
/// Source: Madsen, Nielsen & Tingleff, "Methods for non-linear least squares problems", 2004,
/// (2.21) and (3.16).
class Damping {
 public:
  double value() const { return value_; }
  bool is_hopeless() const { return value_ > 1e16; }

  void Accept(double gain) {
    constexpr double kLeast = 1e-16;
    value_ = std::max(value_ * std::max(1.0 / 3, 1 - std::pow(2 * gain - 1, 3)), kLeast);
    growth_ = 2;
  }
  void Refuse() {
    value_ *= growth_;
    growth_ *= 2;
  }

 private:
  double value_ = 1e-4;
  double growth_ = 2;
};

}  // namespace

Result<BundleSummary> AdjustBundle(BundleProblem& problem, const BundleOptions& options) {
  WAYMARK_TRY(problem.Validate());
  if (problem.observations.empty()) return BundleSummary{.converged = true};
  if (options.solver == BundleSolver::kCeres) {
    return internal::AdjustBundleWithCeres(problem, options);
  }
  constexpr double kLeastGain = 1e-3;  // of the decrease that was promised
  BundleState state = ReadState(problem);
  BundleEquations equations(problem, options);
  double cost = equations.Linearise(state);
  if (!std::isfinite(cost)) {
    return MakeError(ErrorCode::kUnavailable,
                     "bundle: {} poses, {} points: a cost that is no number", problem.poses.size(),
                     problem.points_in_world.size());
  }
  BundleSummary summary{.initial_cost = cost, .final_cost = cost};
  Damping damping;
  while (summary.iterations < options.max_iterations && !damping.is_hopeless()) {
    ++summary.iterations;
    auto step = equations.Solve(state, damping.value());
    if (!step) {
      damping.Refuse();
      continue;
    }
    const double moved_cost = equations.Cost(step->state);
    const double decrease = cost - moved_cost;
    const bool is_better = std::isfinite(moved_cost) && decrease > kLeastGain * step->decrease;
    if (is_better) {
      damping.Accept(decrease / step->decrease);
      state = std::move(step->state);
    } else {
      damping.Refuse();
    }
    if (std::abs(decrease) <= options.relative_tolerance * cost) {
      summary.converged = true;
      if (is_better) cost = moved_cost;
      break;
    }
    if (is_better) cost = equations.Linearise(state);
  }
  summary.final_cost = cost;
  WAYMARK_TRY(WriteBack(std::move(state), problem));
  return summary;
}

}  // namespace waymark::mapping

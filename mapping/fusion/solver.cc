// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/solver.h"

#include <algorithm>
#include <cmath>

namespace waymark::mapping {
namespace {

constexpr double kMaxDamping = 1e8;
// Submaps rest that move by less than this share of the longest motion.
constexpr double kResting = 0.3;
constexpr std::size_t kFew = 4;  // times as many, or looking at all costs less than looking twice

std::size_t CountTrue(const std::vector<bool>& flags) {
  return static_cast<std::size_t>(std::count(flags.begin(), flags.end(), true));
}

}  // namespace

FusionSolver::FusionSolver(const FusionTerms& terms, const std::vector<bool>& is_free,
                           const FusionOptions& options, std::vector<Place>& places)
    : terms_(terms), options_(options), places_(places), whole_(terms, is_free, options, places) {}

Result<SolverSummary> FusionSolver::Solve(OverlapLoss loss, const StopAt& stop) {
  stop_ = stop;
  summary_ = {.steps = 0, .converged = true};
  if (whole_.free_count() == 0) return summary_;
  whole_.Begin(loss);
  WAYMARK_TRY_ASSIGN(summary_.converged, Settle(whole_, stop_.tolerance_m));
  return summary_;
}

/// Steps until none is as long as this. False: the steps are used up, or none lowers the cost.
Result<bool> FusionSolver::Settle(Descent& descent, double motion_m) {
  const auto all = static_cast<double>(whole_.free_count());
  while (summary_.steps < stop_.steps) {
    if (!std::isfinite(descent.cost())) {
      return MakeError(ErrorCode::kUnavailable, "fusing {} submaps: the cost is {}",
                       whole_.free_count(), descent.cost());
    }
    descent.TryStep(stop_.tolerance_m);
    summary_.steps += stop_.parts_count_fully ? 1 : static_cast<double>(descent.free_count()) / all;
    if (descent.damping() > kMaxDamping) return false;
    const double longest_m = descent.longest_motion_m();
    if (longest_m < motion_m) return true;
    if (std::isfinite(longest_m)) {
      WAYMARK_TRY(SettleFarthest(descent, std::max(motion_m, kResting * longest_m)));
    }
  }
  return false;
}

/// A few submaps may take long to settle, such as one between two overlaps that contradict each
/// other. The others rest meanwhile.
Result<void> FusionSolver::SettleFarthest(Descent& descent, double motion_m) {
  std::vector<bool> is_moving = descent.FindMoving(motion_m);
  Widen(terms_, descent.ListFree(), 1, is_moving);
  if (kFew * CountTrue(is_moving) > descent.free_count()) return {};
  Descent part(terms_, is_moving, options_, places_);
  part.BeginAsPart(descent);
  WAYMARK_TRY(Settle(part, motion_m));
  descent.Follow(part);
  return {};
}

void Widen(const FusionTerms& terms, const std::vector<bool>& is_free, int overlaps,
           std::vector<bool>& is_in) {
  for (int i = 0; i < overlaps; ++i) {
    const std::vector<bool> before = is_in;
    for (const auto& [first, second] : terms.pairs) {
      if (before[first]) is_in[second] = true;
      if (before[second]) is_in[first] = true;
    }
  }
  for (std::size_t i = 0; i < is_in.size(); ++i) is_in[i] = is_in[i] && is_free[i];
}

Result<std::vector<double>> PredictMotions(const FusionTerms& terms,
                                           const std::vector<bool>& is_free,
                                           const FusionOptions& options,
                                           const std::vector<Place>& places) {
  Equations equations(terms, is_free, places, options);
  equations.Linearise(places, OverlapLoss::kCauchy);
  const auto step = equations.FindStep(0);
  if (!step) {
    return MakeError(ErrorCode::kUnavailable, "fusing {} submaps: the equations have no solution",
                     equations.free().size());
  }
  std::vector<double> motions_m(places.size(), 0);
  for (std::size_t u = 0; u < step->size(); ++u) {
    const std::uint32_t i = equations.free()[u];
    motions_m[i] = MotionOf((*step)[u], terms.submaps[i], places[i]);
  }
  return motions_m;
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "mapping/fusion/internal/equations.h"

namespace waymark::mapping {
namespace {

constexpr double kLeastDamping = 1e-3;  // once a step was too long
constexpr double kMaxDamping = 1e8;

/// At most how far a step moves an image of the submap.
double MotionOf(const BlockVector& step, const SubmapTerm& term, const Place& place) {
  const double radius_m = std::exp(place.log_scale) * term.radius;
  return step.head<3>().norm() + radius_m * (step.segment<3>(3).norm() + std::abs(step[6]));
}

/// Steps of some submaps, one by one, while all others are held.
class Descent {
 public:
  Descent(const FusionTerms& terms, OverlapLoss loss, const std::vector<bool>& is_free,
          const FusionOptions& options, std::vector<Place>& places)
      : terms_(terms), loss_(loss), equations_(terms, is_free, places, options), places_(places) {
    cost_ = equations_.Linearise(places_, loss_);
  }

  std::size_t free_count() const { return equations_.free().size(); }
  double cost() const { return cost_; }
  double damping() const { return damping_; }
  double longest_motion_m() const { return longest_motion_m_; }

  /// Takes a step when it lowers the cost or nothing moves by the tolerance; else raises the
  /// damping.
  void TryStep(double tolerance_m) {
    const auto step = equations_.FindStep(damping_);
    if (!step) return Damp();
    std::vector<Place> moved = places_;
    motions_m_.assign(step->size(), 0);
    for (std::size_t u = 0; u < step->size(); ++u) {
      const std::uint32_t i = equations_.free()[u];
      motions_m_[u] = MotionOf((*step)[u], terms_.submaps[i], places_[i]);
      moved[i].Move((*step)[u]);
    }
    const double longest_m = *std::max_element(motions_m_.begin(), motions_m_.end());
    const double cost = equations_.Linearise(moved, loss_);
    if (cost <= cost_ || longest_m < tolerance_m) {  // below it the cost is level, but for rounding
      places_ = std::move(moved);
      cost_ = cost;
      // A damped step is short for another reason than that it is over.
      longest_motion_m_ = damping_ > kLeastDamping ? std::max(longest_m, tolerance_m) : longest_m;
      damping_ = damping_ > kLeastDamping ? damping_ / 10 : 0;
    } else {
      equations_.Linearise(places_, loss_);
      Damp();
    }
  }

  /// The submaps that the last step moved by this much.
  std::vector<bool> FindMoving(double motion_m) const {
    std::vector<bool> is_moving(places_.size(), false);
    for (std::size_t u = 0; u < motions_m_.size(); ++u) {
      if (motions_m_[u] >= motion_m) is_moving[equations_.free()[u]] = true;
    }
    return is_moving;
  }

 private:
  void Damp() {
    damping_ = std::max(kLeastDamping, 10 * damping_);
    longest_motion_m_ = std::numeric_limits<double>::infinity();
  }

  const FusionTerms& terms_;
  OverlapLoss loss_;
  Equations equations_;
  std::vector<Place>& places_;
  double cost_ = 0;
  double damping_ = 0;
  std::vector<double> motions_m_;  // by unknown
  double longest_motion_m_ = std::numeric_limits<double>::infinity();
};

std::size_t CountTrue(const std::vector<bool>& flags) {
  return static_cast<std::size_t>(std::count(flags.begin(), flags.end(), true));
}

}  // namespace

void Widen(const FusionTerms& terms, const std::vector<bool>& is_free, int overlaps,
           std::vector<bool>& is_in) {
  for (int i = 0; i < overlaps; ++i) {
    const std::vector<bool> before = is_in;
    for (const OverlapTerm& term : terms.overlaps) {
      if (before[term.first]) is_in[term.second] = true;
      if (before[term.second]) is_in[term.first] = true;
    }
  }
  for (std::size_t i = 0; i < is_in.size(); ++i) is_in[i] = is_in[i] && is_free[i];
}

Result<SolverSummary> SolveFusion(const FusionTerms& terms, OverlapLoss loss, const StopAt& stop,
                                  const std::vector<bool>& is_free, const FusionOptions& options,
                                  std::vector<Place>& places) {
  // A few submaps may take long to settle, such as one between two overlaps that contradict each
  // other. The others rest meanwhile; in the end all have to agree.
  constexpr double kRestingMotion = 0.01;  // of the longest
  const std::size_t all = CountTrue(is_free);
  SolverSummary summary{.steps = 0, .converged = all == 0};
  std::optional<Descent> descent;
  while (!summary.converged && summary.steps < stop.steps) {
    if (!descent) descent.emplace(terms, loss, is_free, options, places);
    if (!std::isfinite(descent->cost())) {
      return MakeError(ErrorCode::kUnavailable, "fusing {} submaps: the cost is {}", all,
                       descent->cost());
    }
    descent->TryStep(stop.tolerance_m);
    summary.steps += static_cast<double>(descent->free_count()) / static_cast<double>(all);
    if (descent->damping() > kMaxDamping) break;
    const bool is_settled = descent->longest_motion_m() < stop.tolerance_m;
    if (is_settled && descent->free_count() == all) {
      summary.converged = true;
    } else if (is_settled) {
      descent.reset();
    } else if (std::isfinite(descent->longest_motion_m())) {
      std::vector<bool> is_moving = descent->FindMoving(
          std::max(stop.tolerance_m, kRestingMotion * descent->longest_motion_m()));
      Widen(terms, is_free, 2, is_moving);
      if (4 * CountTrue(is_moving) < descent->free_count()) {
        descent.emplace(terms, loss, is_moving, options, places);
      }
    }
  }
  return summary;
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

// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/descent.h"

#include <algorithm>
#include <cmath>

namespace waymark::mapping {
namespace {

constexpr double kLeastDamping = 1e-3;  // once a step was too long

}  // namespace

double MotionOf(const BlockVector& step, const SubmapTerm& term, const Place& place) {
  const double radius_m = std::exp(place.log_scale) * term.radius;
  return step.head<3>().norm() + radius_m * (step.segment<3>(3).norm() + std::abs(step[6]));
}

Descent::Descent(const FusionTerms& terms, const std::vector<bool>& is_free,
                 const FusionOptions& options, std::vector<Place>& places)
    : terms_(terms), equations_(terms, is_free, places, options), places_(places) {}

void Descent::Begin(OverlapLoss loss) {
  loss_ = loss;
  equations_.Forget();
  cost_ = equations_.Linearise(places_, loss_);
  damping_ = 0;
  is_behind_ = false;
  longest_motion_m_ = std::numeric_limits<double>::infinity();
}

void Descent::BeginAsPart(const Descent& whole) {
  loss_ = whole.loss_;
  cost_ = equations_.BeginAsPart(whole.equations_, places_, loss_);
}

void Descent::Follow(Descent& part) {
  if (part.is_behind_) part.equations_.Linearise(places_, loss_);
  part.is_behind_ = false;
  cost_ += equations_.Follow(part.equations_);
}

void Descent::TryStep(double tolerance_m) {
  const auto step = equations_.FindStep(damping_);
  if (!step) return Damp();
  const std::vector<std::uint32_t>& free = equations_.free();
  motions_m_.resize(free.size());
  before_.clear();
  for (std::size_t u = 0; u < free.size(); ++u) {
    const std::uint32_t i = free[u];
    motions_m_[u] = MotionOf((*step)[u], terms_.submaps[i], places_[i]);
    before_.push_back(places_[i]);
    places_[i].Move((*step)[u]);
  }
  const double longest_m = *std::max_element(motions_m_.begin(), motions_m_.end());
  if (longest_m < tolerance_m && damping_ <= kLeastDamping) {  // settled: nobody asks for more
    longest_motion_m_ = longest_m;
    is_behind_ = true;
    return;
  }
  const double cost = equations_.Linearise(places_, loss_);
  if (cost <= cost_ || longest_m < tolerance_m) {  // below it the cost is level, but for rounding
    cost_ = cost;
    // A damped step is short for another reason than that it is over.
    longest_motion_m_ = damping_ > kLeastDamping ? std::max(longest_m, tolerance_m) : longest_m;
    damping_ = damping_ > kLeastDamping ? damping_ / 10 : 0;
  } else {
    for (std::size_t u = 0; u < free.size(); ++u) places_[free[u]] = before_[u];
    equations_.Linearise(places_, loss_);
    Damp();
  }
}

std::vector<bool> Descent::ListFree() const {
  std::vector<bool> is_free(places_.size(), false);
  for (const std::uint32_t i : equations_.free()) is_free[i] = true;
  return is_free;
}

std::vector<bool> Descent::FindMoving(double motion_m) const {
  std::vector<bool> is_moving(places_.size(), false);
  for (std::size_t u = 0; u < motions_m_.size(); ++u) {
    if (motions_m_[u] >= motion_m) is_moving[equations_.free()[u]] = true;
  }
  return is_moving;
}

void Descent::Damp() {
  damping_ = std::max(kLeastDamping, 10 * damping_);
  longest_motion_m_ = std::numeric_limits<double>::infinity();
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "mapping/fusion/fusion.h"
#include "mapping/fusion/internal/fusing.h"
#include "mapping/fusion/internal/hypotheses.h"

namespace waymark::mapping {
namespace {

constexpr int kOverlapsAround = 2;  // what is solved with a new submap at first

std::size_t CountTrue(const std::vector<bool>& flags) {
  return static_cast<std::size_t>(std::count(flags.begin(), flags.end(), true));
}

/// The part of the map that is solved anew.
class ChangedPart {
 public:
  ChangedPart(const FusionOptions& options, Fusing& fusing)
      : options_(options), fusing_(fusing), is_in_(fusing.submaps.size(), false) {
    for (std::size_t i = 0; i < is_in_.size(); ++i) {
      is_in_[i] = fusing.is_movable[i] && !fusing.submaps[i].previous;
    }
    Widen(fusing.terms, fusing.is_movable, kOverlapsAround, is_in_);
  }

  const std::vector<bool>& is_in() const { return is_in_; }
  bool IsEmpty() const { return CountTrue(is_in_) == 0; }
  bool IsMostOfMap() const { return 2 * CountTrue(is_in_) > CountTrue(fusing_.is_movable); }

  /// As for the whole map the first time, so that it leads into the same minimum; after that it is
  /// near.
  Result<void> Solve() {
    FusionSolver solver(fusing_.terms, is_in_, options_, fusing_.places);
    if (!std::exchange(was_solved_, true)) {
      WAYMARK_TRY(SolveRound(OverlapLoss::kHuber, options_, solver, fusing_));
      TryOverlaps(fusing_.terms, is_in_, options_, fusing_.places);
    }
    return SolveRound(OverlapLoss::kCauchy, options_, solver, fusing_);
  }

  /// Takes in who would move if all were solved together, and who overlaps them. False: nobody.
  Result<bool> Grow() {
    WAYMARK_TRY_ASSIGN(const std::vector<double> motions_m,
                       PredictMotions(fusing_.terms, fusing_.is_movable, options_, fusing_.places));
    std::vector<bool> moves(is_in_.size(), false);
    bool has_grown = false;
    for (std::size_t i = 0; i < is_in_.size(); ++i) {
      if (is_in_[i] || motions_m[i] < options_.held_motion_m) continue;
      moves[i] = has_grown = true;
    }
    Widen(fusing_.terms, fusing_.is_movable, was_solved_ ? 1 : kOverlapsAround, moves);
    for (std::size_t i = 0; i < is_in_.size(); ++i) is_in_[i] = is_in_[i] || moves[i];
    return has_grown;
  }

 private:
  const FusionOptions& options_;
  Fusing& fusing_;
  std::vector<bool> is_in_;
  bool was_solved_ = false;
};

/// False when so much would move that the whole map has to be solved.
Result<bool> SolveChangedPart(const FusionOptions& options, Fusing& fusing) {
  EstimateSpreads(fusing.places, options, fusing.terms);
  ChangedPart part(options, fusing);
  fusing.fusion.converged = true;  // when there is nothing to solve
  for (bool has_grown = true; has_grown;) {
    if (part.IsMostOfMap()) return false;
    if (!part.IsEmpty()) WAYMARK_TRY(part.Solve());
    WAYMARK_TRY_ASSIGN(has_grown, part.Grow());
  }
  for (std::size_t i = 0; i < fusing.submaps.size(); ++i) {
    fusing.is_held[i] = fusing.submaps[i].previous && !part.is_in()[i];
  }
  return true;
}

}  // namespace

Result<Fusion> UpdateFusion(std::span<const FusionSubmap> submaps, const FusionOptions& options) {
  WAYMARK_TRY(options.Validate());
  if (submaps.empty()) return Fusion{};
  WAYMARK_TRY_ASSIGN(Fusing fusing, BeginFusing(submaps, options));
  const std::vector<Place> first_guess = fusing.places;
  WAYMARK_TRY_ASSIGN(const bool is_done, SolveChangedPart(options, fusing));
  if (!is_done) {
    fusing.places = first_guess;
    WAYMARK_TRY(SolveAll(options, fusing));
  }
  return FinishFusing(options, std::move(fusing));
}

}  // namespace waymark::mapping

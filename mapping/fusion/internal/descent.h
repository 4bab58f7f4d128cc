// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "mapping/fusion/internal/equations.h"

namespace waymark::mapping {

/// At most how far a step moves an image of the submap.
double MotionOf(const BlockVector& step, const SubmapTerm& term, const Place& place);

/// Steps of some submaps, one by one, while all others are held. Borrows everything.
class Descent {
 public:
  Descent(const FusionTerms& terms, const std::vector<bool>& is_free, const FusionOptions& options,
          std::vector<Place>& places);

  /// Begins with this loss at the places of now; before any step.
  void Begin(OverlapLoss loss);

  /// Begins as a part of `whole`, some of whose submaps these are, after a step of it was taken.
  void BeginAsPart(const Descent& whole);

  /// Takes over from a part that began so where its submaps are now.
  void Follow(Descent& part);

  /// Takes a step when it lowers the cost or nothing moves by the tolerance; else raises the
  /// damping. After an undamped step below the tolerance, the equations stay where they were:
  /// begin anew before another.
  void TryStep(double tolerance_m);

  std::size_t free_count() const { return equations_.free().size(); }
  std::vector<bool> ListFree() const;  ///< by submap
  double cost() const { return cost_; }
  double damping() const { return damping_; }
  /// How far the last step moved any image; infinity when it was not taken.
  double longest_motion_m() const { return longest_motion_m_; }

  /// The submaps that the last step moved by this much.
  std::vector<bool> FindMoving(double motion_m) const;

 private:
  void Damp();

  const FusionTerms& terms_;
  OverlapLoss loss_ = OverlapLoss::kHuber;
  Equations equations_;
  std::vector<Place>& places_;
  double cost_ = 0;
  double damping_ = 0;
  bool is_behind_ = false;         // the equations are those before the last step
  std::vector<double> motions_m_;  // by unknown
  std::vector<Place> before_;      // the last step, by unknown
  double longest_motion_m_ = std::numeric_limits<double>::infinity();
};

}  // namespace waymark::mapping

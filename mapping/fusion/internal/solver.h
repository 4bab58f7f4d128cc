// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/fusion/internal/descent.h"
#include "mapping/fusion/internal/terms.h"

namespace waymark::mapping {

struct StopAt {
  double tolerance_m;  ///< no image moves by more
  double steps;        ///< of all free submaps
  bool parts_count_fully =
      false;  ///< a step of some counts as one; otherwise it counts for their share
};

struct SolverSummary {
  double steps = 0;
  bool converged = false;
};

/// Moves the free submaps to where the cost is least and holds all others: Gauss-Newton on
/// reweighted least squares, damped when a step does not lower the cost. Borrows everything; the
/// terms' spreads may change between two rounds.
/// Shapes: is_free and places are by submap; a submap without a place is not free.
class FusionSolver {
 public:
  FusionSolver(const FusionTerms& terms, const std::vector<bool>& is_free,
               const FusionOptions& options, std::vector<Place>& places);

  /// One round. Errors: Unavailable when the cost is not a number.
  Result<SolverSummary> Solve(OverlapLoss loss, const StopAt& stop);

 private:
  Result<bool> Settle(Descent& descent, double motion_m);
  Result<void> SettleFarthest(Descent& descent, double motion_m);

  const FusionTerms& terms_;
  const FusionOptions& options_;
  std::vector<Place>& places_;
  Descent whole_;
  StopAt stop_{};
  SolverSummary summary_;
};

/// How far the next step of all free submaps together would move each (its images at most); zero
/// for the others.
/// Errors: Unavailable when the equations have no solution.
Result<std::vector<double>> PredictMotions(const FusionTerms& terms,
                                           const std::vector<bool>& is_free,
                                           const FusionOptions& options,
                                           const std::vector<Place>& places);

/// Adds the free submaps that can be reached through so many overlaps.
void Widen(const FusionTerms& terms, const std::vector<bool>& is_free, int overlaps,
           std::vector<bool>& is_in);

/// Sets the spread of every overlap: the median displacement of its images, in sigmas, after the
/// two submaps are aligned to each other alone, so that it does not depend on the rest of the map.
void EstimateSpreads(const std::vector<Place>& places, const FusionOptions& options,
                     FusionTerms& terms);

}  // namespace waymark::mapping

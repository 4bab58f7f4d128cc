// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/fusion/internal/terms.h"

namespace waymark::mapping {

struct StopAt {
  double tolerance_m;  ///< no image moves by more
  double steps;        ///< of all free submaps; a step of some counts for their share
};

struct SolverSummary {
  double steps = 0;
  bool converged = false;
};

/// Moves the free submaps to where the cost is least and holds all others: Gauss-Newton on
/// reweighted least squares, damped when a step does not lower the cost.
/// Shapes: is_free and places are by submap; a submap without a place is not free.
/// Errors: Unavailable when the cost is not a number.
Result<SolverSummary> SolveFusion(const FusionTerms& terms, OverlapLoss loss, const StopAt& stop,
                                  const std::vector<bool>& is_free, const FusionOptions& options,
                                  std::vector<Place>& places);

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

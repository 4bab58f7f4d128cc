// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/fusion/internal/solver.h"

namespace waymark::mapping {

/// A fusion on its way: the input made ready, and where the submaps stand by now.
struct Fusing {
  std::span<const FusionSubmap> submaps;
  FusionTerms terms;
  std::vector<bool> is_movable;  ///< has a place and does not fix the gauge
  std::vector<bool> is_placed;
  std::vector<bool> is_held;  ///< stays at its previous place
  std::vector<Place> places;
  Fusion fusion;  ///< without the submaps' places and evidence
};

/// Checks the input, finds overlaps and first guesses. Not for no submaps at all.
Result<Fusing> BeginFusing(std::span<const FusionSubmap> submaps, const FusionOptions& options);

/// One round for the solver's submaps while the others are held.
Result<void> SolveRound(OverlapLoss loss, const FusionOptions& options, FusionSolver& solver,
                        Fusing& fusing);

/// Both rounds for all submaps.
Result<void> SolveAll(const FusionOptions& options, Fusing& fusing);

/// The outcome with its evidence.
Fusion FinishFusing(const FusionOptions& options, Fusing fusing);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "mapping/fusion/fusion.h"
#include "mapping/fusion/internal/overlap.h"

namespace waymark::mapping {

/// How an overlap enters the cost: Huber in the first round, Cauchy in the second.
struct OverlapTerm {
  const Overlap* overlap;
  std::vector<std::uint32_t> chosen;  ///< indices into overlap->images
  double spread = 1;                  ///< expected size of a residual, in sigmas
};

struct SolverProblem {
  std::span<const FusionSubmap> submaps;
  std::span<const OverlapTerm> overlaps;
  std::optional<std::uint32_t> held;
  bool uses_gnss = true;
  bool is_first_round = true;
};

struct SolverSummary {
  int iterations = 0;
  bool converged = false;
};

/// Refines the places of all submaps that have one. The only door to Ceres in this folder.
/// Errors: Unavailable when the solver gives up without a usable solution.
Result<SolverSummary> SolveFusion(const SolverProblem& problem, const FusionOptions& options,
                                  std::vector<std::optional<Sim3>>& map_from_submap);

/// A shared image's displacement in sigmas: what the loss functions see.
double WhitenedDisplacement(const Sim3& map_from_first, const Rigid3& first_from_camera,
                            const Sim3& map_from_second, const Rigid3& second_from_camera,
                            const FusionOptions& options);

}  // namespace waymark::mapping

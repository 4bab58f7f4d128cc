// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/fusing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/fusion/internal/evidence.h"
#include "mapping/fusion/internal/hypotheses.h"

namespace waymark::mapping {
namespace {

// The first round only leads into the second's minimum: what is left to move after these steps are
// submaps that hang by wrong overlaps. A number of steps, as that is the same for a small map and
// for the same streets in a large one.
constexpr StopAt kHuberStop{.tolerance_m = 1e-3, .steps = 8, .parts_count_fully = true};
// Far below what UpdateFusion may differ by.
constexpr double kCauchyToleranceM = 2e-6;

Result<void> CheckSubmaps(std::span<const FusionSubmap> submaps) {
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (submaps[i].images.empty()) {
      return MakeError(ErrorCode::kInvalidArgument, "fusion: submap {} has no images", i);
    }
    if (submaps[i].scale_sigma && !(*submaps[i].scale_sigma > 0)) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "fusion: submap {}: expected scale_sigma > 0, found {}", i,
                       *submaps[i].scale_sigma);
    }
  }
  return {};
}

bool HasGnss(std::span<const FusionSubmap> submaps) {
  return std::ranges::any_of(submaps, [](const FusionSubmap& submap) {
    return submap.is_geo_aligned &&
           std::ranges::any_of(submap.images, [](const FusionImage& image) {
             return image.gnss_in_map.has_value();
           });
  });
}

}  // namespace

Result<Fusing> BeginFusing(std::span<const FusionSubmap> submaps, const FusionOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY(CheckSubmaps(submaps));
  Fusing fusing;
  fusing.submaps = submaps;
  fusing.is_held.assign(submaps.size(), false);
  WAYMARK_TRY_ASSIGN(const std::vector<Overlap> overlaps, FindOverlaps(submaps));
  const bool has_gnss = fusing.fusion.is_geo_referenced = HasGnss(submaps);
  const FirstGuess guess = GuessPlaces(submaps, overlaps, has_gnss, options);
  fusing.terms = MakeTerms(submaps, overlaps, guess.map_from_submap, has_gnss, options);
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const auto& place = guess.map_from_submap[i];
    fusing.is_placed.push_back(place.has_value());
    fusing.is_movable.push_back(place && guess.held != i);
    fusing.places.push_back(
        Place::FromSim3(place.value_or(Sim3()), fusing.terms.submaps[i].centroid_in_submap));
  }
  return fusing;
}

Result<void> SolveRound(OverlapLoss loss, const FusionOptions& options, FusionSolver& solver,
                        Fusing& fusing) {
  const StopAt stop = loss == OverlapLoss::kHuber
                          ? kHuberStop
                          : StopAt{.tolerance_m = kCauchyToleranceM,
                                   .steps = static_cast<double>(options.max_iterations)};
  WAYMARK_TRY_ASSIGN(const SolverSummary summary, solver.Solve(loss, stop));
  fusing.fusion.iterations += static_cast<int>(std::ceil(summary.steps));
  fusing.fusion.converged = summary.converged;
  return {};
}

Result<void> SolveAll(const FusionOptions& options, Fusing& fusing) {
  FusionSolver solver(fusing.terms, fusing.is_movable, options, fusing.places);
  WAYMARK_TRY(SolveRound(OverlapLoss::kHuber, options, solver, fusing));
  EstimateSpreads(fusing.places, options, fusing.terms);
  TryOverlaps(fusing.terms, fusing.is_movable, options, fusing.places);
  return SolveRound(OverlapLoss::kCauchy, options, solver, fusing);
}

Fusion FinishFusing(const FusionOptions& options, Fusing fusing) {
  const std::size_t count = fusing.submaps.size();
  std::vector<FusedSubmap>& fused = fusing.fusion.submaps;
  fused.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!fusing.is_placed[i]) continue;
    fused[i].is_held = fusing.is_held[i];
    const Sim3 map_from_submap =
        fused[i].is_held ? fusing.submaps[i].previous->sim()
                         : fusing.places[i].ToSim3(fusing.terms.submaps[i].centroid_in_submap);
    AddPlace(fusing.submaps[i], map_from_submap, fused[i]);
  }
  AddOverlapEvidence(fusing.terms.overlaps, fusing.places, options, fused);
  return std::move(fusing.fusion);
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/base/median.h"
#include "mapping/fusion/internal/solver.h"

namespace waymark::mapping {
namespace {

constexpr double kMaxSpread = 10;  // a pair further apart than this is wrong, not imprecise

/// Moves the second submap to where the overlap alone wants it.
void Align(const OverlapTerm& term, OverlapLoss loss, const FusionOptions& options,
           const Place& first, Place& second) {
  constexpr int kMaxSteps = 20;
  constexpr double kSmallStep = 1e-4;       // metres and radians
  constexpr double kLeastStiffness = 1e-6;  // few images leave directions open
  OverlapEquations equations;
  for (int i = 0; i < kMaxSteps; ++i) {
    Linearise(term, first, second, loss, options, equations);
    equations.second.diagonal().array() += kLeastStiffness;
    const BlockVector step = -equations.second.llt().solve(equations.gradient_second);
    second.Move(step);
    if (step.norm() < kSmallStep) break;
  }
}

/// The median displacement per component, in sigmas.
double MeasureSpread(const OverlapTerm& term, const FusionOptions& options, const Place& first,
                     const Place& second) {
  const Eigen::Matrix3d map_from_first = first.MapFromArm();
  const Eigen::Matrix3d map_from_second = second.MapFromArm();
  std::vector<double> squares;
  for (const CommonImage& image : term.images) {
    const Eigen::Vector3d shift = first.centroid_in_map + map_from_first * image.arm_in_first -
                                  second.centroid_in_map - map_from_second * image.arm_in_second;
    const Eigen::Vector3d turn =
        CompareOrientations(first.rotation, second.rotation, image.second_from_first).shift_rad;
    squares.push_back((shift / options.overlap_sigma_m).squaredNorm() +
                      (turn / options.orientation_sigma_rad).squaredNorm());
  }
  return std::sqrt(Median(std::move(squares)) / 6);
}

/// How the two submaps stand to each other by their images alone.
struct Pairing {
  double spread;
  Place second;  ///< while the first stays
};

/// Huber first; when that is not the end of it, Cauchy ever narrower, so that wrong images let go,
/// and the least spread on the way.
Pairing PairUp(OverlapTerm term, const Place& first, Place second, const FusionOptions& options) {
  Align(term, OverlapLoss::kHuber, options, first, second);
  Pairing best{MeasureSpread(term, options, first, second), second};
  for (const double spread : {8, 4, 2, 1}) {
    if (best.spread <= 1) break;
    term.spread = spread;
    Align(term, OverlapLoss::kCauchy, options, first, second);
    const double found = MeasureSpread(term, options, first, second);
    if (found < best.spread) best = {found, second};
  }
  best.spread = std::clamp(best.spread, 1.0, kMaxSpread);
  return best;
}

}  // namespace

void EstimateSpreads(const std::vector<Place>& places, const FusionOptions& options,
                     FusionTerms& terms) {
  ParallelFor(terms.overlaps.size(), options.parallelism, [&](std::size_t k) {
    OverlapTerm& term = terms.overlaps[k];
    const Place& first = places[term.first];
    const Pairing pairing = PairUp(term, first, places[term.second], options);
    term.spread = pairing.spread;
    const auto centroid = [&](std::uint32_t submap) {
      return terms.submaps[submap].centroid_in_submap;
    };
    term.first_from_second =
        first.ToSim3(centroid(term.first)).Inverse() * pairing.second.ToSim3(centroid(term.second));
  });
}

}  // namespace waymark::mapping

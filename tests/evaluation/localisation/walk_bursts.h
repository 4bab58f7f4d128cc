// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tests/evaluation/localisation/judging.h"

namespace waymark::evaluation {

/// How phones ask with several keyframes at once.
struct WalkBurstOptions {
  std::size_t images = 5;              ///< at most; a walk's first keyframes have fewer before them
  double odometry_scale_sigma = 0.01;  ///< of a metre, drawn anew for each burst
  std::uint64_t seed = 1;
};

/// Asks every question together with those of the same walk just before it; a walk's first is asked
/// alone. Odometry is level and true but for its metre and its heading, which is arbitrary.
/// Shapes: questions in the order of time, `walk_begins[i]` is the first of the i-th one's walk
std::vector<Verdict> AskInBursts(const localiser::Localiser& localiser,
                                 std::span<const Question> questions,
                                 std::span<const std::size_t> walk_begins,
                                 const WalkBurstOptions& options, const Workshop& workshop);

}  // namespace waymark::evaluation

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "mapping/sfm/incremental.h"

namespace waymark::mapping::internal {

/// Replaces guessed focal lengths by better guesses: of half to twice the guess, the one under
/// which most matches between the camera's own images agree tightly. Ties go to the nearest.
/// Without it a guess that is a quarter off loses most pairs of a turning camera.
std::vector<SfmCamera> ImproveFocalGuesses(std::span<const SfmCamera> cameras,
                                           std::span<const SfmImage> images,
                                           std::span<const PairMatches> matches,
                                           const SfmOptions& options);

}  // namespace waymark::mapping::internal

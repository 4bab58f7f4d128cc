// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "localiser/internal/candidate.h"

namespace waymark::localiser::internal {

/// Submaps of one place are good to centimetres in the map, so where none has enough for itself,
/// what all of them find in the image is asked for one pose: night is known a little by the drive
/// at night, and a little by that in the evening. The pose has to stand by the rules for one
/// submap. It comes in the frame of the submap that shows most of its inliers; landmarks of the
/// others are `kForeignLandmark`. nullopt: fewer than two submaps have matches, or no pose stands.
/// Deterministic.
std::optional<Candidate> AskTogether(std::span<const Candidate> candidates,
                                     const LocalisationRequest& request,
                                     const LocaliserOptions& options);

/// In the place of what its submap said alone.
void PutFirst(Candidate together, std::vector<Candidate>& candidates);

inline constexpr std::uint32_t kForeignLandmark = 0xffffffffU;

}  // namespace waymark::localiser::internal

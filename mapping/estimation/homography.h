// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/estimation/essential.h"

namespace waymark::mapping {

/// How many of the chosen matches one homography explains.
std::size_t CountHomographyInliers(std::span<const NormalizedMatch> matches,
                                   std::span<const std::uint32_t> chosen, double max_error_px,
                                   std::uint64_t seed);

/// The rotation first_from_second that aligns the chosen rays best, robustly.
Eigen::Quaterniond EstimateRotation(std::span<const NormalizedMatch> matches,
                                    std::span<const std::uint32_t> chosen, double max_error_px);

/// Matches that a pure rotation explains; ascending.
std::vector<std::uint32_t> RotationInliers(std::span<const NormalizedMatch> matches,
                                           const Eigen::Quaterniond& first_from_second,
                                           double max_error_px);

}  // namespace waymark::mapping

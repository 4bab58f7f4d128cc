// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>

#include "localiser/internal/image_matches.h"

namespace waymark::localiser::internal {

/// Where a burst was taken, and what its lens and its odometry make of it.
struct BurstState {
  Rigid3 submap_from_vo;
  double focal_factor = 1;  ///< on all cameras' focal lengths
  double scale = 1;         ///< on odometry's translations
};

struct RefinedBurst {
  BurstState state;
  Eigen::Matrix<double, 6, 6> information;  ///< of Perturb's delta for a pixel sigma of 1
  double weighted_squares = 0;              ///< sum of weight * squared residual, px^2
};

struct BurstRefinementOptions {
  double huber_px = 1;  ///< residuals above it count linearly
  int max_iterations = 15;
  double focal_sigma_share = 0;  ///< of the stated focal lengths; 0: exact
  double scale_sigma_share = 0;  ///< of odometry's metre against the submap's; 0: exact
  double pixel_sigma_px = 1;     ///< weighs pixels against what is stated
};

/// Refines a state over the chosen matches of all images, with all six freedoms of the pose, and
/// the focal factor and the scale when they are in doubt: RefinePose for several cameras. nullopt:
/// the matches do not determine a pose, or lie behind their camera.
std::optional<RefinedBurst> RefineBurst(std::span<const BurstCamera> cameras,
                                        const ImageMatches& matches,
                                        std::span<const std::uint32_t> chosen,
                                        const BurstState& start,
                                        const BurstRefinementOptions& options);

/// Where the match would be seen, less where it is. nullopt: not in front of its camera.
std::optional<Eigen::Vector2d> BurstResidualPx(std::span<const BurstCamera> cameras,
                                               const ImageMatches& matches, std::uint32_t match,
                                               const BurstState& state);

}  // namespace waymark::localiser::internal

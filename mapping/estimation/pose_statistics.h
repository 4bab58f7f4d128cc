// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <vector>

namespace waymark::mapping {

// What estimates of poses from many matches, of one image or of several, judge by.

/// Residuals up to so many sigmas count as squares: 95 % efficiency. Source: Huber, 1981.
inline constexpr double kHuberSigmas = 1.345;
/// Rounds of refinement and choice of inliers, after which they seldom change.
inline constexpr int kRefinementRounds = 4;

/// The robust sigma of one component, from the lengths of two-dimensional residuals; at least one.
/// Never less than any feature detector localises to: it keeps a lucky handful of matches from
/// claiming an exact pose.
double RobustSigmaPx(std::vector<double> lengths_px);

/// Whether another focal length or metre than the stated one is to be taken, from the weighted
/// squares that each leaves.
bool IsMuchBetter(double free_squares, double stated_squares);

/// After so many draws a pose with the least inliers asked for would have been found, if there were
/// one; twice, because samples carry noise.
int DrawsWorthMaking(std::size_t matches, std::size_t sample_size, int min_inliers,
                     double confidence, int max_draws);

/// From the information matrix of unit residuals and the squares that the inliers leave. nullopt:
/// something is not determined.
std::optional<Eigen::Matrix<double, 6, 6>> PoseCovariance(
    const Eigen::Matrix<double, 6, 6>& information, double squares_px2, std::size_t inliers);

}  // namespace waymark::mapping

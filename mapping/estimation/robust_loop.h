// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/estimation/progressive_sampler.h"

namespace waymark::mapping {

/// What the robust loop asks of an estimation problem. Errors are squared and in units of the
/// squared inlier threshold, so that 1 separates inliers from outliers.
template <typename P>
concept RobustProblem = requires(const P& problem, const typename P::Model& model,
                                 std::span<const std::uint32_t> sample,
                                 std::vector<typename P::Model>& models,
                                 std::vector<std::uint32_t>& inliers) {
  { P::kSampleSize } -> std::convertible_to<std::size_t>;
  { problem.size() } -> std::convertible_to<std::size_t>;
  problem.Solve(sample, models);  ///< appends every model through a minimal sample
  /// sum of min(error, 1); may stop early with any value above `limit`
  { problem.Cost(model, 0.0) } -> std::convertible_to<double>;
  problem.CollectInliers(model, 1.0, inliers);  ///< ascending indices with error < the bound
  /// least squares over the given correspondences, starting at the model
  { problem.Refine(model, sample) } -> std::same_as<std::optional<typename P::Model>>;
};

struct RobustLoopOptions {
  std::size_t min_inliers = 12;
  double confidence = 0.9999;
  int max_iterations = 10000;
  std::uint64_t seed = 1;
};

template <typename Model>
struct RobustFit {
  Model model;
  double cost;                         ///< sum of min(error, 1)
  std::vector<std::uint32_t> inliers;  ///< ascending
  int iterations;
};

namespace internal {

/// How many draws find an all-inlier sample with this confidence.
inline double DrawsNeeded(double inlier_share, std::size_t sample_size, double confidence) {
  const double all_inliers = std::pow(inlier_share, static_cast<double>(sample_size));
  if (all_inliers >= 1) return 1;
  if (all_inliers < 1e-12) return 1e300;
  return std::log1p(-confidence) / std::log1p(-all_inliers);
}

/// The draws needed, judged on every prefix of the sampling order that holds all draws so far: a
/// small prefix of good matches may settle the matter long before the whole set would.
inline double DrawsNeeded(const ProgressiveSampler& sampler, std::span<const std::uint32_t> inliers,
                          std::size_t sample_size, const RobustLoopOptions& options) {
  std::vector<bool> is_inlier(sampler.order().size());
  for (std::uint32_t i : inliers) is_inlier[i] = true;
  double needed = 1e300;
  std::size_t found = 0;
  std::size_t next_check = std::max<std::size_t>(sampler.pool(), 2 * options.min_inliers);
  for (std::size_t n = 1; n <= is_inlier.size(); ++n) {
    found += is_inlier[sampler.order()[n - 1]] ? 1 : 0;
    if (n != next_check && n != is_inlier.size()) continue;
    next_check = n + n / 4 + 1;
    if (found < options.min_inliers) continue;
    const double share = static_cast<double>(found) / static_cast<double>(n);
    needed = std::min(needed, DrawsNeeded(share, sample_size, options.confidence));
  }
  return needed;
}

/// Improves a model by least squares over its neighbourhood, wide first.
template <RobustProblem P>
void OptimiseLocally(const P& problem, typename P::Model& model, double& cost) {
  std::vector<std::uint32_t> inliers;
  typename P::Model current = model;
  for (const double bound : {4.0, 1.0, 1.0}) {
    problem.CollectInliers(current, bound, inliers);
    if (inliers.size() <= P::kSampleSize) return;
    const auto refined = problem.Refine(current, inliers);
    if (!refined) return;
    current = *refined;
    const double refined_cost = problem.Cost(current, cost);
    if (refined_cost < cost) {
      cost = refined_cost;
      model = current;
    }
  }
}

}  // namespace internal

/// Finds the model that most correspondences support: progressive sampling, truncated quadratic
/// scoring, local optimisation of each new best model, adaptive stop. nullopt: fewer inliers than
/// asked. Deterministic for a seed.
/// Source: Torr & Zisserman, "MLESAC", CVIU 2000 (score); Chum, Matas & Kittler, "Locally
/// optimized RANSAC", DAGM 2003.
template <RobustProblem P>
std::optional<RobustFit<typename P::Model>> RunRobustLoop(const P& problem,
                                                          std::span<const double> quality,
                                                          const RobustLoopOptions& options) {
  using Model = typename P::Model;
  if (problem.size() < std::max(options.min_inliers, P::kSampleSize)) return std::nullopt;
  ProgressiveSampler sampler(problem.size(), quality, P::kSampleSize, options.max_iterations,
                             options.seed);
  constexpr int kMinDraws = 20;
  std::optional<Model> best;
  double best_cost = static_cast<double>(problem.size()) + 1;
  double needed = options.max_iterations;
  std::uint32_t sample[P::kSampleSize];
  std::vector<Model> models;
  std::vector<std::uint32_t> inliers;
  int draw = 0;
  while (draw < options.max_iterations && (draw < kMinDraws || draw < needed)) {
    ++draw;
    sampler.Draw(sample);
    models.clear();
    problem.Solve(sample, models);
    bool improved = false;
    for (const Model& model : models) {
      const double cost = problem.Cost(model, best_cost);
      if (!(cost < best_cost)) continue;
      best = model;
      best_cost = cost;
      improved = true;
    }
    if (!improved) continue;
    internal::OptimiseLocally(problem, *best, best_cost);
    problem.CollectInliers(*best, 1.0, inliers);
    needed = internal::DrawsNeeded(sampler, inliers, P::kSampleSize, options);
  }
  if (!best) return std::nullopt;
  problem.CollectInliers(*best, 1.0, inliers);
  if (inliers.size() < options.min_inliers) return std::nullopt;
  return RobustFit<Model>{*best, best_cost, std::move(inliers), draw};
}

}  // namespace waymark::mapping

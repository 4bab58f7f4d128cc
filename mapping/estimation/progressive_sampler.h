// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

namespace waymark::mapping {

/// Draws minimal samples, those of promising correspondences first: the pool grows from the best
/// few to all of them so that after `max_iterations` draws it has become uniform sampling.
/// Thread-compatible; the sequence depends only on the arguments.
/// Source: Chum & Matas, "Matching with PROSAC", CVPR 2005, eq. (3)-(6).
class ProgressiveSampler {
 public:
  /// Shapes: `quality` has `count` entries (higher is better) or is empty: uniform sampling.
  ///         1 <= sample_size <= count
  ProgressiveSampler(std::size_t count, std::span<const double> quality, std::size_t sample_size,
                     int max_iterations, std::uint64_t seed);

  /// Fills `sample` (sample_size entries) with distinct correspondences.
  void Draw(std::span<std::uint32_t> sample);

  /// Correspondences from most to least promising; all draws so far came from the first `pool()`.
  std::span<const std::uint32_t> order() const { return order_; }
  std::size_t pool() const { return pool_; }

 private:
  void GrowPool();
  std::uint32_t Below(std::size_t bound);

  std::vector<std::uint32_t> order_;
  std::mt19937_64 engine_;
  std::size_t sample_size_;
  std::size_t pool_;
  double expected_draws_;   // T_n of eq. (3)
  double scheduled_draws_;  // T'_n
  double drawn_ = 0;
};

}  // namespace waymark::mapping

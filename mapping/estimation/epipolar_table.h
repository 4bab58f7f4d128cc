// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace waymark::mapping {

/// 2D-2D matches in normalised coordinates laid out for fast scoring of essential matrices.
/// This file and its source know no Eigen: they may be compiled for wider registers.
class EpipolarTable {
 public:
  struct Match {
    float x1, y1, x2, y2;
    float variance1, variance2;  ///< squared inlier threshold in normalised coordinates
  };

  void Add(const Match& match);
  /// Call once after the last Add.
  void Pad();

  std::size_t size() const { return size_; }

  /// Sum over matches of min(squared Sampson error, 1), in units of the threshold.
  /// `essential` is row by row with x1^T E x2 = 0.
  float TruncatedCost(const float essential[9]) const;

 private:
  std::size_t size_ = 0;
  std::vector<float> x1_, y1_, x2_, y2_, variance1_, variance2_;
};

}  // namespace waymark::mapping

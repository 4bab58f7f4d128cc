// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace waymark::mapping {

/// 2D-3D matches laid out for fast scoring: one array per coordinate, padded to whole blocks with
/// matches that never fit. Single precision: points are relative to their own centre.
/// This file and its source know no Eigen: they may be compiled for wider registers.
class ReprojectionTable {
 public:
  /// Scales turn a difference of normalised coordinates into units of the inlier threshold.
  void Add(float x, float y, float z, float u, float v, float scale_u, float scale_v);
  /// Call once after the last Add.
  void Pad();

  std::size_t size() const { return size_; }

  /// Sum over matches of min(squared error, 1); points at or behind the camera count 1.
  /// `pose` is the 3x4 matrix camera_from_world, row by row.
  float TruncatedCost(const float pose[12]) const;

 private:
  std::size_t size_ = 0;
  std::vector<float> x_, y_, z_, u_, v_, scale_u_, scale_v_;
};

}  // namespace waymark::mapping

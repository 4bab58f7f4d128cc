// SPDX-License-Identifier: Apache-2.0
#pragma once

// Read by code for wider registers too: nothing but plain types here.

namespace waymark::mapping::internal {

/// The samples a descriptor is made of: a square grid in the keypoint's own frame, u along its
/// orientation and v a quarter turn clockwise, four samples to a cell. The 20 x 20 in the middle
/// have a gradient; the rim serves their differences.
struct DescriptorGrid {
  static constexpr int kSide = 22;
  static constexpr int kSamples = kSide * kSide;
  static constexpr int kPadded = (kSamples + 15) / 16 * 16;
  static constexpr int kGradientRows = kSide - 2;
  static constexpr int kGradients = kGradientRows * kSide;  ///< with the rim at both row ends
  static constexpr int kPaddedGradients = (kGradients + 15) / 16 * 16;
  static constexpr int kPerCell = 4;

  float u[kPadded];  ///< in cells from the keypoint, row by row
  float v[kPadded];
  /// Lowe's Gaussian of two cells for each gradient; nought at the rim.
  float weights[kPaddedGradients];
};

/// The same for all keypoints.
const DescriptorGrid& TheDescriptorGrid();

}  // namespace waymark::mapping::internal

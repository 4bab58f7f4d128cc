// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::mapping {

/// An 8-bit luminance image, rows without padding.
struct GrayImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> pixels;
};

/// Pixel convention of CameraModel: the centre of the top left pixel is at (0.5, 0.5).
struct Keypoint {
  float x_px;
  float y_px;
  float scale_px;   ///< diameter of the meaningful neighbourhood
  float angle_rad;  ///< orientation, clockwise in the image from +x
};

/// RootSIFT quantised to 8 bit: the square root of the L1-normalised histogram times 512, rounded
/// and clamped to 255. Dot products of two descriptors are near 512^2 times their cosine.
using Descriptor = std::array<std::uint8_t, 128>;

/// Strongest first; keypoints and descriptors have equal length.
struct ImageFeatures {
  std::vector<Keypoint> keypoints;
  std::vector<Descriptor> descriptors;
};

/// The defaults are measured: see README.md.
struct FeatureOptions {
  int max_features = 8192;           ///< strongest kept, [1, 100000]; 8192 is COLMAP's default
  double contrast_threshold = 0.01;  ///< lower finds more in dull light, (0, 1]
  double smoothing_px = 0.8;     ///< Gaussian against sensor noise and aliasing, [0, 10]; 0: none
  int max_image_side_px = 2000;  ///< larger images are reduced first; keypoints stay in full pixels

  Result<void> Validate() const;
};

/// Decodes JPEG or PNG to luminance. EXIF orientation is ignored: pixels as stored.
/// Errors: Corrupt when it does not decode, Unsupported above 100 megapixels.
Result<GrayImage> DecodeGrayImage(std::span<const std::uint8_t> bytes);

/// Scale-invariant features, deterministic. Errors: InvalidArgument for invalid options.
/// Source: Lowe, "Distinctive image features from scale-invariant keypoints", IJCV 2004;
/// Arandjelovic & Zisserman, "Three things everyone should know to improve object retrieval", 2012.
Result<ImageFeatures> ExtractFeatures(const GrayImage& image, const FeatureOptions& options);

}  // namespace waymark::mapping

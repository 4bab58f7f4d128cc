// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/features/features.h"

namespace waymark::mapping {

/// Part of the key that cached features are found by: changes when the same image and options come
/// to give other features.
constexpr int kFeatureRevision = 2;

/// Features of one image as bytes for the feature cache: little-endian, 24 + 144 n bytes.
///   0  8 bytes  "WAYMFEAT"
///   8  u32      version, 1
///  12  u32      n, the number of features
///  16  u64      XXH3 of everything behind the header
///  24  n x 4 f32  x_px, y_px, scale_px, angle_rad
///   …  n x 128 u8  descriptors
/// Encoding the same features gives the same bytes.
std::vector<std::uint8_t> EncodeFeatures(const ImageFeatures& features);

/// Errors: Corrupt (not ours, wrong length, wrong checksum, numbers that are not finite),
/// Unsupported (another version).
Result<ImageFeatures> DecodeFeatures(std::span<const std::uint8_t> bytes);

}  // namespace waymark::mapping

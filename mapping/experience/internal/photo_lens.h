// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace waymark::mapping::internal {

/// What EXIF may say about a lens and its sensor.
struct PhotoLens {
  std::optional<double> focal_mm;
  std::optional<double> focal_in_35mm_film_mm;
  std::optional<double> sensor_width_mm;  ///< from FocalPlaneXResolution and PixelXDimension
};

/// The focal length in pixels of a photo of this size, as stored; nothing when EXIF does not tell.
/// The sensor's width is used where it is plausible and does not contradict the equivalent focal
/// length, which is rounded to whole millimetres; otherwise that one, by the ratio of diagonals.
/// Source: CIPA DCG-001, "35 mm film equivalent focal length" (diagonal of 36 mm x 24 mm).
std::optional<double> FindFocalPx(const PhotoLens& lens, int width_px, int height_px);

}  // namespace waymark::mapping::internal

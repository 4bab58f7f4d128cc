// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::simulator {

/// What a surface sends to the camera, before exposure: three channels per pixel, display gamma.
struct Radiance {
  int width_px = 0;
  int height_px = 0;
  std::vector<float> values;
};

/// Three 8-bit channels per pixel: red, green, blue.
struct ColourImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> values;
};

/// Distance along the optical axis per pixel centre, metres; 0 where there is only sky.
struct DepthImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<double> depth_m;
};

/// Writes a picture as the file name's ending says: .png, or .jpg with a quality in [1, 100].
/// Errors: InvalidArgument (ending), Unavailable (cannot be written). The only door to OpenCV.
Result<void> StorePicture(const ColourImage& picture, const std::filesystem::path& path,
                          int jpeg_quality = 92);

}  // namespace waymark::simulator

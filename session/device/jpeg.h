// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::session {

/// How large an image is sent.
struct ImageSize {
  int max_side_px = 1 << 16;  ///< the longer side is reduced to this, > 0
  int quality = 85;           ///< of JPEG, [0, 100]

  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

struct EncodedImage {
  std::vector<std::uint8_t> jpeg;
  int width_px = 0;
  int height_px = 0;
};

/// Compresses 8-bit luminance, rows without padding, after reducing it by averaging.
/// Errors: InvalidArgument for a size that does not match the pixels, Unavailable if it fails.
Result<EncodedImage> EncodeJpeg(std::span<const std::uint8_t> pixels, int width_px, int height_px,
                                const ImageSize& size);

}  // namespace waymark::session

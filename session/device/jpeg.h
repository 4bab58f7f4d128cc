// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::session {

/// Compresses 8-bit luminance, rows without padding. Quality in [0, 100].
/// Errors: InvalidArgument for a size that does not match the pixels, Unavailable if it fails.
Result<std::vector<std::uint8_t>> EncodeJpeg(std::span<const std::uint8_t> pixels, int width_px,
                                             int height_px, int quality);

}  // namespace waymark::session

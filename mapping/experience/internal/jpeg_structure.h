// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "mapping/base/result.h"

namespace waymark::mapping::internal {

struct JpegSize {
  int width_px;
  int height_px;
};

/// The size of a JPEG whose marker structure is whole, from its first to its last marker; pixels
/// are not decoded. Errors: Corrupt, the message a clause such as "is cut short".
Result<JpegSize> ReadJpegSize(std::span<const std::uint8_t> bytes);

}  // namespace waymark::mapping::internal

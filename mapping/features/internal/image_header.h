// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "mapping/base/result.h"

namespace waymark::mapping::internal {

/// What an encoded image says of itself before anything is decoded or allocated.
struct ImageHeader {
  std::int64_t width_px;
  std::int64_t height_px;
};

/// Reads the size of a JPEG or PNG and walks its segments to the end, so that a truncated file is
/// found out here: libjpeg would fill the missing part with grey and report success.
/// Errors: Corrupt (neither format, a broken segment, no pixels, no end),
/// Unsupported (more scans than any camera writes: a few bytes that cost minutes).
Result<ImageHeader> DecodeImageHeader(std::span<const std::uint8_t> bytes);

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/internal/jpeg_structure.h"

#include <optional>

namespace waymark::mapping::internal {
namespace {

constexpr std::uint8_t kStartOfImage = 0xD8;
constexpr std::uint8_t kEndOfImage = 0xD9;
constexpr std::uint8_t kStartOfScan = 0xDA;

bool IsStartOfFrame(std::uint8_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

int BigEndian16(std::span<const std::uint8_t> bytes) { return bytes[0] << 8 | bytes[1]; }

/// Whether an end marker follows in compressed data, in which a 0xFF of the data itself is
/// followed by 0.
bool HasEndOfImage(std::span<const std::uint8_t> bytes) {
  for (std::size_t i = 0; i + 1 < bytes.size(); ++i) {
    if (bytes[i] == 0xFF && bytes[i + 1] == kEndOfImage) return true;
  }
  return false;
}

}  // namespace

Result<JpegSize> ReadJpegSize(std::span<const std::uint8_t> bytes) {
  const Error cut_short{ErrorCode::kCorrupt, "is cut short"};
  if (bytes.size() < 2 || bytes[0] != 0xFF || bytes[1] != kStartOfImage) {
    return Error{ErrorCode::kCorrupt, "is no JPEG"};
  }
  std::optional<JpegSize> size;
  std::size_t at = 2;
  while (true) {
    while (at < bytes.size() && bytes[at] == 0xFF) ++at;  // fill bytes before a marker
    if (at + 3 > bytes.size()) return cut_short;
    const std::uint8_t marker = bytes[at++];
    const auto length = static_cast<std::size_t>(BigEndian16(bytes.subspan(at, 2)));
    if (length < 2 || length > bytes.size() - at) return cut_short;
    const auto segment = bytes.subspan(at + 2, length - 2);
    if (IsStartOfFrame(marker) && segment.size() >= 5) {
      size = JpegSize{BigEndian16(segment.subspan(3, 2)), BigEndian16(segment.subspan(1, 2))};
    }
    at += length;
    if (marker == kStartOfScan) break;
    if (at >= bytes.size()) return cut_short;
    if (bytes[at] != 0xFF) return Error{ErrorCode::kCorrupt, "is a damaged JPEG"};
  }
  if (!HasEndOfImage(bytes.subspan(at))) return cut_short;
  if (!size || size->width_px == 0 || size->height_px == 0) {
    return Error{ErrorCode::kCorrupt, "is a JPEG without an image size"};
  }
  return *size;
}

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/image_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

namespace waymark::mapping::internal {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::array<std::uint8_t, 8> kPngSignature = {0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a};

std::uint32_t ReadBigEndian(Bytes bytes, std::size_t offset, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[offset + i];
  return value;
}

Error Truncated(std::string_view format, std::size_t size) {
  return MakeError(ErrorCode::kCorrupt, "{} image: expected more after its {} bytes", format, size);
}

Result<ImageHeader> CheckSize(std::string_view format, const std::optional<ImageHeader>& header) {
  if (!header || header->width_px == 0 || header->height_px == 0) {
    return MakeError(ErrorCode::kCorrupt, "{} image: expected a size, found none", format);
  }
  return *header;
}

Result<ImageHeader> DecodePngHeader(Bytes bytes) {
  std::optional<ImageHeader> header;
  std::size_t offset = kPngSignature.size();
  while (true) {  // chunk: length, type, data, checksum
    if (bytes.size() - offset < 12) return Truncated("PNG", bytes.size());
    const std::size_t length = ReadBigEndian(bytes, offset, 4);
    if (bytes.size() - offset - 12 < length) return Truncated("PNG", bytes.size());
    const std::uint8_t* const type = bytes.data() + offset + 4;
    if (std::memcmp(type, "IHDR", 4) == 0 && length >= 8 && !header) {
      header = {ReadBigEndian(bytes, offset + 8, 4), ReadBigEndian(bytes, offset + 12, 4)};
    }
    if (std::memcmp(type, "IEND", 4) == 0) return CheckSize("PNG", header);
    offset += 12 + length;
  }
}

/// Each scan makes the decoder pass over the whole image again, whatever its size in bytes.
constexpr int kMaxScans = 100;  ///< usual progressive files have about ten

bool StartsJpegFrame(std::uint8_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

/// The offset just behind the next marker at or after `offset`; nothing if the bytes end first.
/// Entropy-coded data in between is skipped: there 0xff is followed by 0, a restart or a fill byte.
std::optional<std::size_t> FindJpegMarker(Bytes bytes, std::size_t offset) {
  while (offset + 1 < bytes.size()) {
    const void* const found = std::memchr(bytes.data() + offset, 0xff, bytes.size() - offset - 1);
    if (!found) return std::nullopt;
    offset = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes.data()) + 1;
    const std::uint8_t marker = bytes[offset];
    const bool restart = marker >= 0xd0 && marker <= 0xd7;
    if (marker != 0 && marker != 0xff && !restart) return offset + 1;
  }
  return std::nullopt;
}

Result<ImageHeader> DecodeJpegHeader(Bytes bytes) {
  std::optional<ImageHeader> header;
  std::size_t offset = 2;
  int scans = 0;
  while (true) {
    const auto behind = FindJpegMarker(bytes, offset);
    if (!behind) return Truncated("JPEG", bytes.size());
    const std::uint8_t marker = bytes[*behind - 1];
    if (marker == 0xd9) return CheckSize("JPEG", header);  // end of image
    if (bytes.size() - *behind < 2) return Truncated("JPEG", bytes.size());
    const std::size_t length = ReadBigEndian(bytes, *behind, 2);
    if (length < 2 || bytes.size() - *behind < length) return Truncated("JPEG", bytes.size());
    if (marker == 0xda && ++scans > kMaxScans) {
      return MakeError(ErrorCode::kUnsupported, "JPEG image: expected at most {} scans, found more",
                       kMaxScans);
    }
    if (StartsJpegFrame(marker) && length >= 8 && !header) {
      header = {ReadBigEndian(bytes, *behind + 5, 2), ReadBigEndian(bytes, *behind + 3, 2)};
    }
    offset = *behind + length;
  }
}

}  // namespace

Result<ImageHeader> DecodeImageHeader(Bytes bytes) {
  if (bytes.size() >= 2 && bytes[0] == 0xff && bytes[1] == 0xd8) return DecodeJpegHeader(bytes);
  if (bytes.size() >= kPngSignature.size() &&
      std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin())) {
    return DecodePngHeader(bytes);
  }
  return MakeError(ErrorCode::kCorrupt, "image of {} bytes: expected JPEG or PNG", bytes.size());
}

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#include "session/wire/parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace waymark::session::wire {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::uint8_t kKind = 7;  // beside those of frames.cc
constexpr std::size_t kHeaderBytes = 16;

struct Header {
  std::array<std::uint8_t, 4> kind{kKind, 0, 0, 0};
  std::uint32_t number = 0, total = 0, offset = 0;
};
static_assert(sizeof(Header) == kHeaderBytes);

}  // namespace

std::vector<std::vector<std::uint8_t>> Cut(std::span<const std::uint8_t> frame,
                                           std::uint32_t number) {
  std::vector<std::vector<std::uint8_t>> parts;
  for (std::size_t offset = 0; offset < frame.size(); offset += kPartBytes) {
    const auto content = frame.subspan(offset, std::min(kPartBytes, frame.size() - offset));
    const Header header{.number = number,
                        .total = static_cast<std::uint32_t>(frame.size()),
                        .offset = static_cast<std::uint32_t>(offset)};
    std::vector<std::uint8_t>& part = parts.emplace_back(kHeaderBytes + content.size());
    std::memcpy(part.data(), &header, kHeaderBytes);
    std::copy(content.begin(), content.end(), part.begin() + kHeaderBytes);
  }
  return parts;
}

bool IsPart(std::span<const std::uint8_t> frame) { return !frame.empty() && frame[0] == kKind; }

Result<std::optional<std::vector<std::uint8_t>>> PartCollector::Add(
    std::span<const std::uint8_t> part) {
  using Whole = std::optional<std::vector<std::uint8_t>>;
  Header header;
  if (part.size() < kHeaderBytes) {
    return MakeError(ErrorCode::kCorrupt, "part: {} bytes are no header", part.size());
  }
  std::memcpy(&header, part.data(), kHeaderBytes);
  const auto content = part.subspan(kHeaderBytes);
  const bool is_cut_right =
      IsPart(part) && header.offset % kPartBytes == 0 && header.offset < header.total &&
      content.size() == std::min<std::size_t>(kPartBytes, header.total - header.offset);
  if (!is_cut_right) {
    return MakeError(ErrorCode::kCorrupt, "part: {} bytes are none at {} of {}", content.size(),
                     header.offset, header.total);
  }
  if (header.total > max_bytes_) {
    return MakeError(ErrorCode::kInvalidArgument, "part: of {} bytes, at most {} are taken",
                     header.total, max_bytes_);
  }
  if (header.offset == 0) {
    bytes_.clear();
    number_ = header.number;
    total_ = header.total;
  }
  if (header.number != number_ || header.total != total_ || header.offset != bytes_.size()) {
    return Whole();
  }
  bytes_.insert(bytes_.end(), content.begin(), content.end());
  if (bytes_.size() < total_) return Whole();
  total_ = 0;
  return Whole(std::exchange(bytes_, {}));
}

}  // namespace waymark::session::wire

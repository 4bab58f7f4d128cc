// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/base/result.h"

/// Large frames cut into small ones, so that on a stream others go between, and the rest of one can
/// be left out. A part is four octets as before any frame (idl/README.md), then, little-endian, the
/// number of the whole, its size and the offset of what follows, 32 bits each.
namespace waymark::session::wire {

/// 40 ms of a slow phone's network, and little beside what TLS and a WebSocket add. All parts but
/// the last hold so much.
inline constexpr std::size_t kPartBytes = 4096;

/// Wholes that follow each other on a stream need different numbers.
std::vector<std::vector<std::uint8_t>> Cut(std::span<const std::uint8_t> frame,
                                           std::uint32_t number);

bool IsPart(std::span<const std::uint8_t> frame);

/// Puts the parts of a stream together. One whole at a time: the first part of another ends the one
/// before. Thread-compatible.
class PartCollector {
 public:
  explicit PartCollector(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// The whole, with its last part. Parts of a whole that was given up say nothing.
  /// Errors: Corrupt (not cut by `Cut`), InvalidArgument (too large).
  Result<std::optional<std::vector<std::uint8_t>>> Add(std::span<const std::uint8_t> part);

 private:
  const std::size_t max_bytes_;
  std::uint32_t number_ = 0;
  std::size_t total_ = 0;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace waymark::fuzz {

using Bytes = std::vector<std::uint8_t>;

inline Bytes ToBytes(std::string_view text) { return {text.begin(), text.end()}; }
inline std::string_view ToText(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Decodes the bytes as they are, and once more with right checksums, so that damage reaches the
/// rules behind them.
inline void TryAlsoRestamped(std::span<const std::uint8_t> bytes,
                             void (*decode)(std::span<const std::uint8_t>),
                             void (*restamp)(Bytes&)) {
  decode(bytes);
  Bytes restamped(bytes.begin(), bytes.end());
  restamp(restamped);
  decode(restamped);
}

// A fuzz target is one source that defines these two; the drivers beside it call them.

/// Valid inputs to start from.
std::vector<Bytes> Seeds();

/// Decodes; ends the process when a property is broken. Whatever the bytes, nothing else may.
void TryOne(std::span<const std::uint8_t> bytes);

}  // namespace waymark::fuzz

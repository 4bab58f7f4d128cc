// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

namespace waymark::content::internal {

/// SQL counts to 2^63 - 1; what is beyond finds nothing there either.
inline std::int64_t Clamp(std::uint64_t value) {
  constexpr auto kLargest = std::numeric_limits<std::int64_t>::max();
  return value > static_cast<std::uint64_t>(kLargest) ? kLargest : static_cast<std::int64_t>(value);
}

}  // namespace waymark::content::internal

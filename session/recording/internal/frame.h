// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

/// What goes before the records of a file, and before each.
namespace waymark::session::recording::internal {

inline constexpr std::string_view kMagic = "WAYMARKREC\r\n";

struct RecordHead {
  std::uint32_t size = 0;      ///< of the record
  std::uint64_t checksum = 0;  ///< XXH3-64 of it
};
inline constexpr std::size_t kRecordHeadBytes = 12;

}  // namespace waymark::session::recording::internal

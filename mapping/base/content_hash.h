// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace waymark {

/// XXH3 128-bit hash of bytes as 32 hex digits: names content, finds damage, resists no forger.
std::string ContentHash(std::span<const std::uint8_t> bytes);
std::string ContentHash(std::string_view text);

/// XXH3 64-bit hash of bytes: section checksums.
std::uint64_t Checksum(std::span<const std::uint8_t> bytes);

}  // namespace waymark

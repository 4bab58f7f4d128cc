// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace waymark::session {

using Uuid = std::array<std::uint8_t, 16>;

/// A version 4 UUID from 128 random bits; the caller owns the randomness.
Uuid UuidFromBits(std::uint64_t high, std::uint64_t low);

/// "8-4-4-4-12" in lower case.
std::string FormatUuid(const Uuid& uuid);

/// The inverse of FormatUuid; upper case is understood too. Nothing for any other text.
std::optional<Uuid> FindUuid(std::string_view text);

}  // namespace waymark::session

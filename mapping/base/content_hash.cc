// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/content_hash.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace waymark {

std::string ContentHash(std::span<const std::uint8_t> bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::string ContentHash(std::string_view text) {
  return ContentHash(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::uint64_t Checksum(std::span<const std::uint8_t> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace waymark

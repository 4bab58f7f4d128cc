// SPDX-License-Identifier: Apache-2.0
#include <xxhash.h>

#include <cstring>

#include "mapping/base/check.h"
#include "mapping/io/internal/submap_layout.h"
#include "mapping/io/submap_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/mapping/io/example_submap.h"

namespace waymark::fuzz {
namespace {

namespace layout = mapping::internal;

void Restamp(Bytes& bytes) {
  if (bytes.size() < layout::kHeaderSize) return;
  for (std::size_t i = 0; i < layout::kSectionCount; ++i) {
    std::uint8_t* entry = bytes.data() + layout::kTableOffset + i * layout::kTableEntrySize;
    std::uint64_t offset = 0, count = 0;
    std::memcpy(&offset, entry + 8, 8);
    std::memcpy(&count, entry + 16, 8);
    const std::uint64_t size = count * layout::kElementSizes[i];
    if (offset > bytes.size() || count > bytes.size() || size > bytes.size() - offset) continue;
    const std::uint64_t checksum = XXH3_64bits(bytes.data() + offset, size);
    std::memcpy(entry + 24, &checksum, 8);
  }
  const std::uint64_t checksum = XXH3_64bits(bytes.data(), layout::kHeaderChecksumOffset);
  std::memcpy(bytes.data() + layout::kHeaderChecksumOffset, &checksum, 8);
}

void Decode(std::span<const std::uint8_t> bytes) {
  const auto model = mapping::DecodeSubmap(bytes);
  if (!model) return;
  const auto again = mapping::EncodeSubmap(*model);
  CHECK(again.ok(), "what was decoded cannot be encoded");
  CHECK(mapping::DecodeSubmap(*again).ok(), "what was encoded cannot be decoded");
}

}  // namespace

std::vector<Bytes> Seeds() {
  std::vector<Bytes> seeds;
  for (std::uint32_t landmarks : {0U, 1U, 7U}) {
    seeds.push_back(*mapping::EncodeSubmap(mapping::ExampleSubmap(landmarks, landmarks)));
  }
  return seeds;
}

void TryOne(std::span<const std::uint8_t> bytes) { TryAlsoRestamped(bytes, Decode, Restamp); }

}  // namespace waymark::fuzz

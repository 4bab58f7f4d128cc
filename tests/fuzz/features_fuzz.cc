// SPDX-License-Identifier: Apache-2.0
#include <xxhash.h>

#include <cstring>

#include "mapping/base/check.h"
#include "mapping/features/feature_codec.h"
#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {
namespace {

constexpr std::size_t kHeaderSize = 24;

void Restamp(Bytes& bytes) {
  if (bytes.size() < kHeaderSize) return;
  const std::uint64_t checksum =
      XXH3_64bits(bytes.data() + kHeaderSize, bytes.size() - kHeaderSize);
  std::memcpy(bytes.data() + 16, &checksum, 8);
}

void Decode(std::span<const std::uint8_t> bytes) {
  const auto features = mapping::DecodeFeatures(bytes);
  if (!features) return;
  const Bytes again = mapping::EncodeFeatures(*features);
  CHECK(std::equal(again.begin(), again.end(), bytes.begin(), bytes.end()),
        "encoding again gives other bytes");
}

}  // namespace

std::vector<Bytes> Seeds() {
  std::vector<Bytes> seeds;
  for (int count : {0, 1, 3}) {
    mapping::ImageFeatures features;
    for (int i = 0; i < count; ++i) {
      features.keypoints.push_back({10.5F * static_cast<float>(i), 20.25F, 2, 0.5F});
      features.descriptors.emplace_back();
      features.descriptors.back().fill(static_cast<std::uint8_t>(i + 3));
    }
    seeds.push_back(mapping::EncodeFeatures(features));
  }
  return seeds;
}

void TryOne(std::span<const std::uint8_t> bytes) { TryAlsoRestamped(bytes, Decode, Restamp); }

}  // namespace waymark::fuzz

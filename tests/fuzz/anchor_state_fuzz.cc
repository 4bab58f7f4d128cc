// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/record_codec.h"
#include "mapping/base/check.h"
#include "tests/content_store/anchor_fixtures.h"
#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {

using content::internal::DecodeState;
using content::internal::EncodeState;

std::vector<Bytes> Seeds() {
  std::vector<Bytes> seeds;
  for (std::uint64_t n : {0U, 1U, 3U, 90U}) {
    seeds.push_back(ToBytes(EncodeState({.record = content::MakeAnchor(n), .creation = "0abc"})));
  }
  seeds.push_back(ToBytes(EncodeState({.record = content::MakeAnchor(5), .is_deleted = true})));
  return seeds;
}

void TryOne(std::span<const std::uint8_t> bytes) {
  const auto state = DecodeState(ToText(bytes));
  if (!state) return;
  CHECK(DecodeState(EncodeState(*state)).ok(), "what was encoded cannot be decoded");
}

}  // namespace waymark::fuzz

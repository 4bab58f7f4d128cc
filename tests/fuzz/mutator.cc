// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutator.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace waymark::fuzz {
namespace {

std::ptrdiff_t Offset(std::size_t value) { return static_cast<std::ptrdiff_t>(value); }

}  // namespace

std::size_t Mutator::Below(std::size_t bound) { return bound == 0 ? 0 : engine_() % bound; }

Bytes Mutator::Mutate(Bytes bytes, const Bytes& other) {
  for (std::size_t left = 1 + Below(4); left > 0; --left) MutateOnce(bytes, other);
  return bytes;
}

void Mutator::Overwrite(Bytes& bytes) {
  constexpr std::array<std::uint64_t, 10> kExtremes{0,
                                                    1,
                                                    0x7f,
                                                    0x80,
                                                    0xff,
                                                    0x7fffffff,
                                                    0x80000000,
                                                    0xffffffffffffffff,
                                                    0x7ff0000000000000 /* infinity */,
                                                    0x7ff8000000000000 /* NaN */};
  constexpr std::array<std::size_t, 4> kSizes{1, 2, 4, 8};
  const std::size_t size = std::min(kSizes[Below(kSizes.size())], bytes.size());
  const std::uint64_t value = kExtremes[Below(kExtremes.size())];
  std::memcpy(bytes.data() + Below(bytes.size() - size + 1), &value, size);
}

void Mutator::MutateOnce(Bytes& bytes, const Bytes& other) {
  if (bytes.empty()) {
    bytes = other;
    return;
  }
  const std::size_t at = Below(bytes.size());
  const std::size_t length = 1 + Below(std::min<std::size_t>(bytes.size() - at, 64));
  switch (Below(7)) {
    case 0:
      bytes[at] ^= static_cast<std::uint8_t>(1U << Below(8));
      break;
    case 1:
      bytes[at] = static_cast<std::uint8_t>(engine_());
      break;
    case 2:
      Overwrite(bytes);
      break;
    case 3:
      bytes.resize(at);
      break;
    case 4:
      bytes.erase(bytes.begin() + Offset(at), bytes.begin() + Offset(at + length));
      break;
    case 5: {
      const Bytes piece(bytes.begin() + Offset(at), bytes.begin() + Offset(at + length));
      bytes.insert(bytes.begin() + Offset(Below(bytes.size())), piece.begin(), piece.end());
      break;
    }
    default: {
      if (other.empty()) break;
      const std::size_t from = Below(other.size());
      const std::size_t count = std::min({length, other.size() - from, bytes.size() - at});
      std::copy_n(other.begin() + Offset(from), count, bytes.begin() + Offset(at));
    }
  }
}

}  // namespace waymark::fuzz

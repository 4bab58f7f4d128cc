// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {

/// Damages inputs the way that finds mistakes in decoders: flipped bits, extreme numbers, missing,
/// repeated and foreign pieces. Deterministic for a seed.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : engine_(seed) {}

  /// One to four mutations of an input; `other` lends pieces.
  Bytes Mutate(Bytes bytes, const Bytes& other);

 private:
  std::size_t Below(std::size_t bound);
  void MutateOnce(Bytes& bytes, const Bytes& other);
  void Overwrite(Bytes& bytes);

  std::mt19937_64 engine_;
};

}  // namespace waymark::fuzz

// SPDX-License-Identifier: Apache-2.0
// Hands libFuzzer's inputs to the target; seeds come from `--write-seeds` of the standalone
// program.
#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  waymark::fuzz::TryOne({data, size});
  return 0;
}

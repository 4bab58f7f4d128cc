// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace waymark::mapping::internal {

/// The last `capacity` rows of an image that is made from top to bottom.
struct RowRing {
  float* data = nullptr;
  std::ptrdiff_t stride = 0;
  int capacity = 0;

  float* Row(int y) const { return data + y % capacity * stride; }
};

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace waymark {

/// The value that a share in [0, 1] of the values does not exceed: always one of them, between two
/// the lower; `of_none` when there is none. Move the values in where they are needed no more.
template <typename Value = double>
Value Quantile(std::vector<Value> values, double share, Value of_none = Value()) {
  if (values.empty()) return of_none;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace waymark

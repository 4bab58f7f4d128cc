// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "mapping/base/check.h"

namespace waymark {

/// The upper median: of an even number of values the greater of the two in the middle, so that the
/// answer is always one of them. `values` is not empty; move it in where it is needed no more.
inline double Median(std::vector<double> values) {
  CHECK(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace waymark

// SPDX-License-Identifier: Apache-2.0
#include "mapping/split/internal/sampling.h"

#include <algorithm>
#include <utility>

namespace waymark::mapping {

std::vector<std::uint32_t> SampleValues(std::vector<std::uint32_t> values, std::size_t count,
                                        std::mt19937_64& random) {
  if (values.size() > count) {
    for (std::size_t i = 0; i < count; ++i) {
      std::swap(values[i], values[i + random() % (values.size() - i)]);
    }
    values.resize(count);
  }
  std::sort(values.begin(), values.end());
  return values;
}

}  // namespace waymark::mapping

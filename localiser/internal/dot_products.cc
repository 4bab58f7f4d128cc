// SPDX-License-Identifier: Apache-2.0
// No Eigen here: code for wider registers must not share its types (alignment differs).
#include "localiser/internal/dot_products.h"

#include <array>

namespace waymark::localiser::internal {
namespace {

constexpr std::size_t kDimensions = std::tuple_size_v<mapping::Descriptor>;

/// In 16 bit, for which processors have a multiplication that adds neighbours.
using WideDescriptor = std::array<std::int16_t, kDimensions>;

#if defined(__x86_64__)
__attribute__((target_clones("arch=skylake-avx512", "avx2", "default")))
#endif
void ComputeWide(const std::int16_t* query, const std::uint8_t* entries, std::size_t count,
                 std::int32_t* dots) {
  for (std::size_t e = 0; e < count; ++e) {
    const std::uint8_t* entry = entries + e * kDimensions;
    std::int32_t sum = 0;
    for (std::size_t i = 0; i < kDimensions; ++i) {
      sum += std::int32_t{query[i]} * static_cast<std::int16_t>(entry[i]);
    }
    dots[e] = sum;
  }
}

}  // namespace

void ComputeDots(const mapping::Descriptor& query, std::span<const mapping::Descriptor> entries,
                 std::span<std::int32_t> dots) {
  static_assert(sizeof(mapping::Descriptor) == kDimensions, "descriptors lie back to back");
  if (entries.empty()) return;
  WideDescriptor wide;
  for (std::size_t i = 0; i < kDimensions; ++i) wide[i] = query[i];
  ComputeWide(wide.data(), entries.front().data(), entries.size(), dots.data());
}

}  // namespace waymark::localiser::internal

// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/top_cells.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <limits>

#include "localiser/internal/clones.h"
#include "localiser/internal/group_kernels.h"

namespace waymark::localiser::internal {
namespace {

constexpr std::size_t kStrides = 64;
constexpr std::size_t kVectors = kStrides / kGroupLanes;
using Strides = std::array<std::int32_t, kStrides>;

// The compiler's own, on every processor: what it makes of loops depends on what it knows of
// memory.
using Lanes = std::int32_t __attribute__((vector_size(4 * kGroupLanes)));

__attribute__((always_inline)) inline void Load(const std::int32_t* from, Lanes& lanes) {
  std::memcpy(&lanes, from, sizeof(lanes));
}

/// The largest of each stride. What does not fill a last round is left out: the bound stays one.
WAYMARK_CLONES void FindBestOfStrides(const std::int32_t* dots, std::size_t count,
                                      Strides& strides) {
  Lanes best[kVectors];
  for (std::size_t v = 0; v < kVectors; ++v) Load(dots + v * kGroupLanes, best[v]);
  for (std::size_t begin = kStrides; begin + kStrides <= count; begin += kStrides) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      Lanes here;
      Load(dots + begin + v * kGroupLanes, here);
      best[v] = here > best[v] ? here : best[v];
    }
  }
  std::memcpy(strides.data(), best, sizeof(strides));
}

}  // namespace

TopCells::TopCells(std::size_t cells, std::size_t wanted)
    : wanted_(wanted),
      is_bounded_(wanted <= kStrides && cells >= 4 * kStrides),
      candidates_(cells + kGroupLanes) {}

void TopCells::AppendTo(std::span<const std::int32_t> dots, std::vector<std::uint32_t>& cells) {
  std::int32_t bound = std::numeric_limits<std::int32_t>::min();
  if (is_bounded_) {
    Strides best;
    FindBestOfStrides(dots.data(), dots.size(), best);
    const auto last = best.begin() + static_cast<std::ptrdiff_t>(wanted_ - 1);
    std::nth_element(best.begin(), last, best.end(), std::greater<>());
    bound = *last;
  }
  const auto at_least = SupportedGroupKernels().front().at_least;
  const std::size_t found = at_least(dots, bound, candidates_.data());
  order_.clear();
  for (const std::uint32_t cell : std::span(candidates_).first(found)) {
    order_.push_back(-std::int64_t{dots[cell]} * (1LL << 32) + std::int64_t{cell});
  }
  std::ranges::sort(order_);
  for (const std::int64_t best : std::span(order_).first(wanted_)) {
    cells.push_back(static_cast<std::uint32_t>(best));  // the lower half
  }
}

}  // namespace waymark::localiser::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <utility>

#include "mapping/fusion/internal/large_pages.h"

namespace waymark::mapping {

/// Sorts by an unsigned number, ascending, equal ones as they were. The time is linear in the items
/// for numbers of so many bits, and so the same per item in a large map as in a small one.
/// Source: Knuth, "The Art of Computer Programming", vol. 3, section 5.2.5.
template <typename Item, typename Key>
void RadixSort(LargeVector<Item>& items, Key&& key) {
  constexpr int kBits = 11;
  constexpr std::uint64_t kMask = (1u << kBits) - 1;
  std::uint64_t differing = 0;
  for (const Item& item : items) differing |= key(item) ^ key(items.front());
  LargeVector<Item> sorted(items.size());
  for (int shift = 0; shift < 64 && differing >> shift != 0; shift += kBits) {
    if ((differing >> shift & kMask) == 0) continue;
    std::array<std::size_t, kMask + 1> begin{};
    for (const Item& item : items) ++begin[key(item) >> shift & kMask];
    std::size_t sum = 0;
    for (std::size_t& of_digit : begin) sum += std::exchange(of_digit, sum);
    for (const Item& item : items) sorted[begin[key(item) >> shift & kMask]++] = item;
    items.swap(sorted);
  }
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace waymark::mapping::internal {

/// Allocates what fills pages of 2 MiB from such pages, where the system has them: a factor of
/// 10,000 submaps is some 30 MB, their images are 50 MB, and finding 4 KiB pages costs time, too.
template <typename T>
struct LargePages {
  using value_type = T;

  LargePages() = default;
  template <typename Other>
  LargePages(const LargePages<Other>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    void* const memory = ::operator new(bytes, AlignmentOf(bytes));
    if (bytes >= kPage) madvise(memory, bytes / kPage * kPage, MADV_HUGEPAGE);  // may be refused
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    ::operator delete(memory, AlignmentOf(count * sizeof(T)));
  }
  /// What is not given a value has none: memory that will be written need not be cleared.
  template <typename Item>
  void construct(Item* item) {
    ::new (static_cast<void*>(item)) Item;
  }
  template <typename Item, typename... Arguments>
  void construct(Item* item, Arguments&&... arguments) {
    ::new (static_cast<void*>(item)) Item{std::forward<Arguments>(arguments)...};
  }
  bool operator==(const LargePages&) const { return true; }

 private:
  static constexpr std::size_t kPage = std::size_t{2} << 20;

  static std::align_val_t AlignmentOf(std::size_t bytes) {
    return std::align_val_t{bytes >= kPage ? kPage : alignof(T)};
  }
};

}  // namespace waymark::mapping::internal

namespace waymark::mapping {

template <typename T>
using LargeVector = std::vector<T, internal::LargePages<T>>;

}  // namespace waymark::mapping

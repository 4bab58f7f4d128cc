// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "content_store/anchor_record.h"

/// The words for enumerators in files that people read.
namespace waymark::content::internal {

inline constexpr std::array<std::string_view, 3> kVisibilityNames{"private", "room", "public"};
inline constexpr std::array<std::string_view, 2> kEditingNames{"everyone", "owner"};

inline std::string_view NameOf(AnchorVisibility visibility) {
  return kVisibilityNames[static_cast<std::size_t>(visibility)];
}
inline std::string_view NameOf(AnchorEditing editing) {
  return kEditingNames[static_cast<std::size_t>(editing)];
}

/// The enumerator whose name this is.
template <typename Enum, std::size_t n>
std::optional<Enum> FindNamed(const std::array<std::string_view, n>& names, std::string_view name) {
  for (std::size_t i = 0; i < n; ++i) {
    if (names[i] == name) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

}  // namespace waymark::content::internal

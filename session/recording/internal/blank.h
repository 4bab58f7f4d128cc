// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>

#include "mapping/base/id.h"

namespace waymark::session::recording::internal {

template <typename T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Lets overloads that come later be found.
struct Here {};

/// A value to read into, for types that have no default.
template <typename T>
T Blank(Here, std::type_identity<T>) {
  return T{};
}
template <typename Tag>
Id<Tag> Blank(Here, std::type_identity<Id<Tag>>) {
  return Id<Tag>("");
}

}  // namespace waymark::session::recording::internal

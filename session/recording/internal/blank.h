// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>
#include <utility>

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

template <typename A, typename B>
std::pair<A, B> Blank(Here here, std::type_identity<std::pair<A, B>>) {
  return {Blank(here, std::type_identity<A>()), Blank(here, std::type_identity<B>())};
}

}  // namespace waymark::session::recording::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>

/// How generated types are laid out as bytes: XCDR version 2, little-endian, without the
/// encapsulation header. Source: OMG DDS-XTypes 1.3, 7.4.
namespace waymark::session::wire {

/// The members of a generated type in order, and whether more may follow in later versions:
///   static constexpr bool kAppendable; template <…> static void Visit(archive, value);
template <typename Wire>
struct Layout;

/// A sequence with the bound that the IDL gives it.
template <typename Sequence>
struct AtMost {
  Sequence& items;
  std::uint32_t bound;
};
template <typename Sequence>
AtMost(Sequence&, std::uint32_t) -> AtMost<Sequence>;  // clang 14 makes none of aggregates

template <typename T>
concept Number = std::integral<T> || std::floating_point<T>;
template <typename T>
concept Sequence = requires(T t) {
  t._buffer;
  t._length;
};

template <typename T>
concept LaidOut = requires {
  Layout<T>::kAppendable;
};

inline constexpr std::size_t kMaxAlignment = 4;

}  // namespace waymark::session::wire

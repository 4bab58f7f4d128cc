// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace waymark {

/// The identity of a thing, spelled as text that is safe in file names and on the wire.
/// Ids of different things do not compare. There is no "no id" value: absence is std::optional.
template <typename Tag>
class Id {
 public:
  explicit Id(std::string text) : text_(std::move(text)) {}

  const std::string& text() const { return text_; }

  friend auto operator<=>(const Id&, const Id&) = default;

 private:
  std::string text_;
};

/// A position in one particular vector. Positions in different vectors do not compare.
template <typename Tag>
class Index {
 public:
  constexpr explicit Index(std::size_t value) : value_(static_cast<std::uint32_t>(value)) {}

  constexpr std::uint32_t value() const { return value_; }

  friend constexpr auto operator<=>(const Index&, const Index&) = default;

 private:
  std::uint32_t value_;
};

using ExperienceId =
    Id<struct ExperienceTag>;           ///< one recording of one vehicle, chosen by its user
using SubmapId = Id<struct SubmapTag>;  ///< content hash of a submap file, 32 hex digits
using AnchorId = Id<struct AnchorTag>;  ///< UUID
using DeviceId = Id<struct DeviceTag>;  ///< one phone in one room
using RoomId = Id<struct RoomTag>;

}  // namespace waymark

template <typename Tag>
struct std::hash<waymark::Id<Tag>> {
  std::size_t operator()(const waymark::Id<Tag>& id) const noexcept {
    return std::hash<std::string>{}(id.text());
  }
};

template <typename Tag>
struct std::hash<waymark::Index<Tag>> {
  std::size_t operator()(const waymark::Index<Tag>& index) const noexcept {
    return std::hash<std::uint32_t>{}(index.value());
  }
};

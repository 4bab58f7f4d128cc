// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace waymark::content::internal {

/// An inner page of one of SQLite's B-trees: where to go on for a key. Whatever the bytes, nothing
/// is read beyond them; a page that is no such page, or a key that is none, is nullopt. Borrows the
/// bytes. Source: SQLite, "Database File Format", 1.6 B-tree Pages, 2.1 Record Format.
class SqliteInnerPage {
 public:
  /// What the first two columns of an index's entry are.
  struct IndexKey {
    std::string_view text;
    std::int64_t number = 0;
    friend auto operator<=>(const IndexKey&, const IndexKey&) = default;
  };

  static std::optional<SqliteInnerPage> Parse(std::span<const std::uint8_t> page);

  std::size_t key_count() const { return count_; }  ///< there is one child more
  /// The page that holds what is not above key i, and above those before; i <= key_count().
  std::uint32_t Child(std::size_t i) const;
  /// Of a table; i < key_count().
  std::optional<std::int64_t> Rowid(std::size_t i) const;
  /// Of an index whose first columns are a text and a number; i < key_count().
  std::optional<IndexKey> Key(std::size_t i) const;

 private:
  explicit SqliteInnerPage(std::span<const std::uint8_t> page) : page_(page) {}

  std::span<const std::uint8_t> Cell(std::size_t i) const;

  std::span<const std::uint8_t> page_;
  bool is_index_ = false;
  std::size_t count_ = 0;
};

}  // namespace waymark::content::internal

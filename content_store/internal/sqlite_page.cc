// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sqlite_page.h"

#include <array>
#include <utility>

namespace waymark::content::internal {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint8_t kInnerIndex = 2, kInnerTable = 5;
constexpr std::size_t kHeader = 12, kPointer = 4;

template <typename T>
T BigEndian(Bytes bytes) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = static_cast<T>(value << 8 | bytes[i]);
  return value;
}

/// Takes a number of 1 to 9 bytes off the front.
std::optional<std::uint64_t> TakeVarint(Bytes& bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 9 && i < bytes.size(); ++i) {
    const std::uint8_t byte = bytes[i];
    value = i == 8 ? value << 8 | byte : value << 7 | (byte & 0x7f);
    if (i < 8 && (byte & 0x80) != 0) continue;
    bytes = bytes.subspan(i + 1);
    return value;
  }
  return std::nullopt;
}

/// Bytes of an integer of this serial type; nullopt: it is none.
std::optional<std::size_t> IntegerBytes(std::uint64_t serial_type) {
  constexpr std::array<std::size_t, 10> kSizes{0, 1, 2, 3, 4, 6, 8, 0, 0, 0};
  if (serial_type == 0 || serial_type == 7 || serial_type >= kSizes.size()) return std::nullopt;
  return kSizes[serial_type];
}

std::int64_t ToInteger(Bytes bytes, std::uint64_t serial_type) {
  if (bytes.empty()) return serial_type == 9 ? 1 : 0;
  std::uint64_t value = (bytes[0] & 0x80) != 0 ? ~std::uint64_t{0} : 0;
  for (const std::uint8_t byte : bytes) value = value << 8 | byte;
  return static_cast<std::int64_t>(value);
}

}  // namespace

std::optional<SqliteInnerPage> SqliteInnerPage::Parse(Bytes page) {
  if (page.size() < kHeader || (page[0] != kInnerIndex && page[0] != kInnerTable)) return {};
  SqliteInnerPage parsed(page);
  parsed.is_index_ = page[0] == kInnerIndex;
  parsed.count_ = BigEndian<std::uint16_t>(page.subspan(3));
  if (kHeader + 2 * parsed.count_ > page.size()) return {};
  return parsed;
}

// Empty where there is none.
Bytes SqliteInnerPage::Cell(std::size_t i) const {
  const std::size_t at = BigEndian<std::uint16_t>(page_.subspan(kHeader + 2 * i));
  if (at + kPointer > page_.size()) return {};
  return page_.subspan(at);
}

std::uint32_t SqliteInnerPage::Child(std::size_t i) const {
  if (i >= count_) return BigEndian<std::uint32_t>(page_.subspan(8));
  const Bytes cell = Cell(i);
  return cell.empty() ? 0 : BigEndian<std::uint32_t>(cell);
}

std::optional<std::int64_t> SqliteInnerPage::Rowid(std::size_t i) const {
  Bytes rest = Cell(i);
  if (is_index_ || rest.empty()) return std::nullopt;
  rest = rest.subspan(kPointer);
  const auto rowid = TakeVarint(rest);
  return rowid ? std::optional(static_cast<std::int64_t>(*rowid)) : std::nullopt;
}

std::optional<SqliteInnerPage::IndexKey> SqliteInnerPage::Key(std::size_t i) const {
  Bytes rest = Cell(i);
  if (!is_index_ || rest.empty()) return std::nullopt;
  rest = rest.subspan(kPointer);
  if (!TakeVarint(rest)) return std::nullopt;  // size of all; what we want is at its beginning
  Bytes header = rest;
  const auto header_size = TakeVarint(header);
  if (!header_size || *header_size > rest.size()) return std::nullopt;
  const auto text_type = TakeVarint(header), number_type = TakeVarint(header);
  if (!text_type || !number_type || *text_type < 13 || *text_type % 2 == 0) return std::nullopt;
  const std::uint64_t text_size = (*text_type - 13) / 2;
  const auto number_size = IntegerBytes(*number_type);
  const Bytes body = rest.subspan(*header_size);
  if (!number_size || text_size > body.size() || *number_size > body.size() - text_size) {
    return std::nullopt;
  }
  return IndexKey{{reinterpret_cast<const char*>(body.data()), text_size},
                  ToInteger(body.subspan(text_size, *number_size), *number_type)};
}

}  // namespace waymark::content::internal

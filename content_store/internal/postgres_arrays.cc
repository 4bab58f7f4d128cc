// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_arrays.h"

#include <fmt/format.h>

namespace waymark::content::internal {
namespace {

void AppendHex(std::string& text, std::string_view bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  text.reserve(text.size() + 2 * bytes.size());
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
}

int DigitOf(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

}  // namespace

void PostgresArray::Add(std::int64_t number) {
  Separate();
  text_ += fmt::format_int(number).str();
}

void PostgresArray::Add(const std::optional<std::int64_t>& number) {
  if (number) return Add(*number);
  Separate();
  text_ += "NULL";
}

void PostgresArray::AddHex(std::string_view bytes) {
  Separate();
  text_ += '"';  // an empty text needs them
  AppendHex(text_, bytes);
  text_ += '"';
}

std::optional<std::string> FindHexBytes(std::string_view digits) {
  if (digits.size() % 2 != 0) return std::nullopt;
  std::string bytes;
  bytes.reserve(digits.size() / 2);
  for (std::size_t i = 0; i < digits.size(); i += 2) {
    const int high = DigitOf(digits[i]), low = DigitOf(digits[i + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    bytes += static_cast<char>(high << 4 | low);
  }
  return bytes;
}

std::string ToHex(std::string_view bytes) {
  std::string text;
  AppendHex(text, bytes);
  return text;
}

}  // namespace waymark::content::internal

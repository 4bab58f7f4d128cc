// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace waymark::content::internal {

/// An array as PostgreSQL reads it from one bound parameter. Texts and bytes go as hex digits, so
/// there is nothing to quote whatever they hold.
class PostgresArray {
 public:
  void Add(std::int64_t number);
  void Add(const std::optional<std::int64_t>& number);
  void AddHex(std::string_view bytes);
  /// "{1,2,NULL}"
  std::string Text() const { return text_ + "}"; }

 private:
  void Separate() {
    if (text_.size() > 1) text_ += ',';
  }

  std::string text_ = "{";
};

/// Bytes of hex digits as encode(…, 'hex') gives them; nothing if they are none.
std::optional<std::string> FindHexBytes(std::string_view digits);

/// Hex digits of bytes, two for each.
std::string ToHex(std::string_view bytes);

}  // namespace waymark::content::internal

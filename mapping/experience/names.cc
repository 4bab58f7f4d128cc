// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/names.h"

#include <cstdint>

namespace waymark::mapping {
namespace {

/// How many bytes follow the first one of a UTF-8 sequence; negative for a byte that starts none.
int ContinuationCount(std::uint8_t first) {
  if (first < 0x80) return 0;
  if (first >= 0xC2 && first < 0xE0) return 1;
  if (first >= 0xE0 && first < 0xF0) return 2;
  if (first >= 0xF0 && first < 0xF5) return 3;
  return -1;
}

/// Refuses what the first byte alone cannot tell: overlong forms, surrogates, beyond U+10FFFF.
bool IsAllowedSecondByte(std::uint8_t first, std::uint8_t second) {
  if (first == 0xE0) return second >= 0xA0;
  if (first == 0xED) return second < 0xA0;
  if (first == 0xF0) return second >= 0x90;
  if (first == 0xF4) return second < 0x90;
  return true;
}

}  // namespace

bool IsPrintableText(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto first = static_cast<std::uint8_t>(text[i]);
    if (first < 0x20 || first == 0x7F) return false;
    const int following = ContinuationCount(first);
    if (following < 0 || text.size() - i <= static_cast<std::size_t>(following)) return false;
    for (int k = 1; k <= following; ++k) {
      const auto next = static_cast<std::uint8_t>(text[++i]);
      if ((next & 0xC0) != 0x80) return false;
      if (k == 1 && !IsAllowedSecondByte(first, next)) return false;
    }
  }
  return true;
}

bool IsExperienceIdText(std::string_view text) {
  return !text.empty() && text.size() <= 200 && text.front() != '.' &&
         text.find('/') == std::string_view::npos && IsPrintableText(text);
}

bool IsImageName(std::string_view text) {
  if (text.empty() || text.size() > 1000 || !IsPrintableText(text)) return false;
  while (true) {
    const std::size_t slash = text.find('/');
    const std::string_view part = text.substr(0, slash);
    if (part.empty() || part == "." || part == "..") return false;
    if (slash == std::string_view::npos) return true;
    text.remove_prefix(slash + 1);
  }
}

}  // namespace waymark::mapping

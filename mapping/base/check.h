// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string_view>

namespace waymark::internal {

[[noreturn]] void FailCheck(const char* file, int line, const char* condition,
                            std::string_view message);

inline std::string CheckMessage() { return {}; }

template <typename... Args>
std::string CheckMessage(fmt::format_string<Args...> format, Args&&... args) {
  return fmt::format(format, std::forward<Args>(args)...);
}

}  // namespace waymark::internal

/// Aborts when one of our own assumptions is broken; never used for input.
/// `CHECK(n > 0)` or `CHECK(n > 0, "n is {}", n)`.
#define CHECK(condition, ...)                                                         \
  do {                                                                                \
    if (!(condition)) [[unlikely]]                                                    \
      ::waymark::internal::FailCheck(__FILE__, __LINE__, #condition,                  \
                                     ::waymark::internal::CheckMessage(__VA_ARGS__)); \
  } while (false)

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <string>
#include <type_traits>

namespace waymark::mapping::internal {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

/// Appends a number's bytes.
template <typename T>
void AppendBinary(std::string& bytes, T value) {
  static_assert(std::is_arithmetic_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace waymark::mapping::internal

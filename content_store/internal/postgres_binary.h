// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace waymark::content::internal {

/// A bigint as PostgreSQL sends and receives it in binary.
std::string ToBinary(std::int64_t number);
/// Its counterpart. Errors: throws std::runtime_error unless there are 8 bytes.
std::int64_t FromBinary(std::string_view bytes);

/// An array as PostgreSQL receives it in binary: whatever its elements hold, nothing is quoted.
class BinaryArray {
 public:
  /// The object ids of bytea, bigint and text, which never change.
  enum Type : std::uint32_t { kBytes = 17, kNumber = 20, kText = 25 };

  explicit BinaryArray(Type type) : type_(type) {}
  /// An element of kBytes or kText.
  void Add(std::string_view bytes);
  /// An element of kNumber; absent: NULL.
  void Add(std::optional<std::int64_t> number);

  std::string Take() &&;

 private:
  const Type type_;
  std::size_t count_ = 0;
  std::string elements_;
};

}  // namespace waymark::content::internal

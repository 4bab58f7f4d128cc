// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_binary.h"

#include <concepts>
#include <stdexcept>

namespace waymark::content::internal {
namespace {

template <std::unsigned_integral T>
void AppendBigEndian(std::string& bytes, T value) {
  for (std::size_t i = sizeof(T); i-- > 0;) bytes += static_cast<char>(value >> (8 * i));
}

}  // namespace

std::string ToBinary(std::int64_t number) {
  std::string bytes;
  AppendBigEndian(bytes, static_cast<std::uint64_t>(number));
  return bytes;
}

std::int64_t FromBinary(std::string_view bytes) {
  if (bytes.size() != 8) throw std::runtime_error("expected a bigint of 8 bytes from the database");
  std::uint64_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<std::uint8_t>(byte);
  return static_cast<std::int64_t>(value);
}

void BinaryArray::Add(std::string_view bytes) {
  ++count_;
  AppendBigEndian(elements_, static_cast<std::uint32_t>(bytes.size()));
  elements_ += bytes;
}

void BinaryArray::Add(std::optional<std::int64_t> number) {
  if (number) return Add(ToBinary(*number));
  ++count_;
  AppendBigEndian(elements_, ~std::uint32_t{0});  // a length of -1: NULL
}

std::string BinaryArray::Take() && {
  std::string array;
  array.reserve(elements_.size() + 20);
  AppendBigEndian(array, std::uint32_t{1});  // dimensions
  AppendBigEndian(array, std::uint32_t{1});  // NULLs are possible
  AppendBigEndian(array, static_cast<std::uint32_t>(type_));
  AppendBigEndian(array, static_cast<std::uint32_t>(count_));
  AppendBigEndian(array, std::uint32_t{1});  // index of the first
  return array += elements_;
}

}  // namespace waymark::content::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <vector>

#include "session/wire/internal/cdr.h"
#include "session/wire/internal/values.h"

namespace waymark::session::wire {

/// Appends generated types to bytes.
class CdrWriter {
 public:
  explicit CdrWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes), origin_(bytes.size()) {}

  template <typename... Members>
  void operator()(const Members&... members) {
    (Write(members), ...);
  }

 private:
  template <Number T>
  void Write(const T& value) {
    Align(std::min(sizeof(T), kMaxAlignment));
    const auto* const begin = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), begin, begin + sizeof(T));
  }
  template <typename T>
  requires std::is_enum_v<T>
  void Write(const T& value) { Write(static_cast<std::uint32_t>(value)); }
  template <std::size_t N>
  void Write(const char (&text)[N]) {
    const std::size_t length = ::strnlen(text, N - 1);
    Write(static_cast<std::uint32_t>(length + 1));
    bytes_.insert(bytes_.end(), text, text + length);
    bytes_.push_back(0);
  }
  template <Number T, std::size_t N>
  void Write(const T (&items)[N]) {
    for (const T& item : items) Write(item);
  }
  template <Sequence T>
  void Write(const T& sequence) {
    using Item = std::remove_pointer_t<decltype(sequence._buffer)>;
    const auto write_items = [&] {
      Write(sequence._length);
      if constexpr (sizeof(Item) == 1) {
        bytes_.insert(bytes_.end(), sequence._buffer, sequence._buffer + sequence._length);
      } else {
        for (const Item& item : Items(sequence)) Write(item);
      }
    };
    Number<Item> ? write_items() : Delimit(write_items);
  }
  template <typename T>
  void Write(const AtMost<T>& sequence) {
    Write(sequence.items);
  }
  template <typename T>
  void Write(T* const& optional) {
    Write(optional != nullptr);
    if (optional != nullptr) Write(*optional);
  }
  template <LaidOut T>
  void Write(const T& value) {
    const auto visit = [&] { Layout<T>::Visit(*this, value); };
    Layout<T>::kAppendable ? Delimit(visit) : visit();
  }

  /// Writes the size of what `write` writes before it.
  template <typename F>
  void Delimit(const F& write) {
    Write(std::uint32_t{0});
    const std::size_t begin = bytes_.size();
    write();
    const auto size = static_cast<std::uint32_t>(bytes_.size() - begin);
    std::memcpy(bytes_.data() + begin - sizeof(size), &size, sizeof(size));
  }

  void Align(std::size_t alignment) {
    while ((bytes_.size() - origin_) % alignment != 0) bytes_.push_back(0);
  }

  std::vector<std::uint8_t>& bytes_;
  std::size_t origin_;
};

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

#include "session/wire/internal/cdr.h"
#include "session/wire/internal/values.h"

namespace waymark::session::wire {

/// Reads generated types from what anybody on the internet may have sent; Cyclone's own reader
/// serves packets of a trusted network. Reads into values that are all zero. Nothing is read beyond
/// the bytes, and no more is allocated than they and the bounds of sequences account for.
class CdrReader {
 public:
  CdrReader(std::span<const std::uint8_t> bytes, Scratch& scratch)
      : bytes_(bytes), end_(bytes.size()), scratch_(scratch) {}

  /// Whether all went well and nothing but padding is left.
  bool IsComplete() const { return is_good_ && bytes_.size() - at_ < kMaxAlignment; }

  template <typename... Members>
  void operator()(Members&&... members) {
    (ReadMember(members), ...);
  }

 private:
  /// An older writer of an appendable type knows fewer members; they stay zero.
  template <typename T>
  void ReadMember(T& member) {
    if (is_good_ && !(may_end_ && at_ == end_)) Read(member);
  }

  template <Number T>
  void Read(T& value) {
    if (!Align(std::min(sizeof(T), kMaxAlignment)) || end_ - at_ < sizeof(T)) return Fail();
    if constexpr (std::is_same_v<T, bool>) {
      if (bytes_[at_] > 1) return Fail();
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
  }
  template <typename T>
  requires std::is_enum_v<T>
  void Read(T& value) {
    std::uint32_t number = 0;
    Read(number);
    value = static_cast<T>(number);
  }
  template <std::size_t N>
  void Read(char (&text)[N]) {
    std::uint32_t size = 0;  // with the final zero
    Read(size);
    if (!is_good_ || size < 1 || size > N || end_ - at_ < size) return Fail();
    if (bytes_[at_ + size - 1] != 0) return Fail();
    std::memcpy(text, bytes_.data() + at_, size);
    at_ += size;
  }
  template <Number T, std::size_t N>
  void Read(T (&items)[N]) {
    for (T& item : items) Read(item);
  }
  template <typename T>
  void Read(AtMost<T>& sequence) {
    ReadSequence(sequence.items, sequence.bound);
  }
  template <Sequence T>
  void Read(T& octets) {
    static_assert(sizeof(*octets._buffer) == 1, "other sequences have a bound");
    ReadSequence(octets, static_cast<std::uint32_t>(end_ - at_));
  }
  template <typename T>
  void Read(T*& optional) {
    bool is_there = false;
    Read(is_there);
    if (!is_good_ || !is_there) return;
    optional = scratch_.Allocate<T>(1);
    Read(*optional);
  }
  template <LaidOut T>
  void Read(T& value) {
    const auto visit = [&] { Layout<T>::Visit(*this, value); };
    if constexpr (Layout<T>::kAppendable) {
      Delimited(visit, true);
    } else {
      const bool could_end = std::exchange(may_end_, false);
      visit();
      may_end_ = could_end;
    }
  }

  template <Sequence T>
  void ReadSequence(T& sequence, std::uint32_t bound) {
    using Item = std::remove_pointer_t<decltype(sequence._buffer)>;
    const auto read_items = [&] {
      std::uint32_t count = 0;
      Read(count);
      if (!is_good_ || count > bound || count > end_ - at_) return Fail();
      Item* const items = scratch_.Allocate<Item>(count);
      if constexpr (sizeof(Item) == 1) {
        std::memcpy(items, bytes_.data() + at_, count);
        at_ += count;
      } else {
        for (std::uint32_t i = 0; i < count && is_good_; ++i) Read(items[i]);
      }
      PointTo(sequence, items, count);
    };
    Number<Item> ? read_items() : Delimited(read_items, false);
  }

  /// Reads within the size that stands before, and goes on behind it.
  template <typename F>
  void Delimited(const F& read, bool may_end) {
    std::uint32_t size = 0;
    Read(size);
    if (!is_good_ || size > end_ - at_) return Fail();
    const std::size_t outer_end = std::exchange(end_, at_ + size);
    const bool could_end = std::exchange(may_end_, may_end);
    read();
    at_ = end_;
    end_ = outer_end;
    may_end_ = could_end;
  }

  bool Align(std::size_t alignment) {
    const std::size_t aligned = (at_ + alignment - 1) / alignment * alignment;
    if (!is_good_ || aligned > end_) return false;
    at_ = aligned;
    return true;
  }

  void Fail() { is_good_ = false; }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  std::size_t end_;  // of the innermost delimited part
  Scratch& scratch_;
  bool may_end_ = false;
  bool is_good_ = true;
};

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <array>
#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/geometry/frames.h"
#include "session/recording/internal/blank.h"
#include "session/recording/ticket_names.h"

/// As archive.h says.
namespace waymark::session::recording::internal {

/// Reads what anybody may have written. Nothing is read beyond the bytes, and no more is allocated
/// than they account for.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  /// Whether all went well and nothing is left.
  bool IsComplete() const { return is_good_ && bytes_.empty(); }

  template <typename... Ts>
  void operator()(Ts&... values) {
    (Take(values), ...);
  }

 private:
  template <Number T>
  void Take(T& value) {
    if (!Has(sizeof value)) return;
    if constexpr (std::is_same_v<T, bool>) {
      if (bytes_[0] > 1) return Fail();
    }
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
  }
  void Take(std::string& text) {
    const std::size_t size = TakeCount();
    text.assign(reinterpret_cast<const char*>(bytes_.data()), size);
    bytes_ = bytes_.subspan(size);
  }
  template <typename Tag>
  void Take(Id<Tag>& id) {
    std::string text;
    Take(text);
    id = Id<Tag>(std::move(text));
  }
  template <typename Clock, typename Duration>
  void Take(std::chrono::time_point<Clock, Duration>& instant) {
    std::int64_t count = 0;
    Take(count);
    instant = std::chrono::time_point<Clock, Duration>(Duration(count));
  }
  template <typename Rep, typename Period>
  void Take(std::chrono::duration<Rep, Period>& duration) {
    std::int64_t count = 0;
    Take(count);
    duration = std::chrono::duration<Rep, Period>(count);
  }
  template <typename T, std::size_t N>
  void Take(std::array<T, N>& items) {
    for (T& item : items) Take(item);
  }
  template <int N>
  void Take(Eigen::Matrix<double, N, 1>& vector) {
    for (double& value : vector) Take(value);
  }
  void Take(Rigid3& rigid) {
    Eigen::Vector4d rotation;
    Eigen::Vector3d translation;
    for (double& value : rotation) Take(value);
    Take(translation);
    if (!is_good_) return;
    rigid = Rigid3(Eigen::Quaterniond::Identity(), translation);
    // The constructor would normalise it once more, which moves the last bit. `rigid` is no const
    // object, so it may be written to.
    const_cast<Eigen::Quaterniond&>(rigid.rotation()).coeffs() = rotation;
  }
  template <typename To, typename From>
  void Take(Transform<To, From>& transform) {
    Rigid3 rigid;
    Take(rigid);
    transform = Transform<To, From>(rigid);
  }
  template <typename To, typename From>
  void Take(Similarity<To, From>& similarity) {
    double scale = 1;
    Rigid3 rigid;
    (*this)(scale, rigid);
    Sim3 sim(scale, Eigen::Quaterniond::Identity(), rigid.translation());
    const_cast<Eigen::Quaterniond&>(sim.rotation()).coeffs() = rigid.rotation().coeffs();
    similarity = Similarity<To, From>(sim);
  }
  template <typename T>
  void Take(std::vector<T>& items) {
    const std::size_t count = TakeCount();
    for (std::size_t i = 0; i < count && is_good_; ++i) Take(items.emplace_back(New<T>()));
  }
  template <typename T>
  void Take(std::set<T>& items) {
    const std::size_t count = TakeCount();
    for (std::size_t i = 0; i < count && is_good_; ++i) items.insert(TakeNew<T>());
  }
  template <typename K, typename V>
  void Take(std::map<K, V>& items) {
    const std::size_t count = TakeCount();
    for (std::size_t i = 0; i < count && is_good_; ++i) {
      K key = TakeNew<K>();
      items.insert_or_assign(std::move(key), TakeNew<V>());
    }
  }
  template <typename A, typename B>
  void Take(std::pair<A, B>& pair) {
    (*this)(pair.first, pair.second);
  }
  template <typename T>
  void Take(std::optional<T>& value) {
    bool is_there = false;
    Take(is_there);
    if (is_good_ && is_there) value = TakeNew<T>();
  }
  template <typename T>
  void Take(std::shared_ptr<const T>& value) {
    bool is_there = false;
    Take(is_there);
    if (is_good_ && is_there) value = std::make_shared<const T>(TakeNew<T>());
  }
  template <typename T>
  void Take(Result<T>& result) {
    bool is_ok = false;
    Take(is_ok);
    if (!is_good_) return;
    if (is_ok) {
      result = Result<T>(TakeNew<T>());
      return;
    }
    Error error{ErrorCode::kCorrupt, ""};
    (*this)(error.code, error.message);
    if (error.code < ErrorCode{} || error.code > ErrorCode::kUnsupported) return Fail();
    result = Result<T>(std::move(error));
  }
  template <typename... Ts>
  void Take(std::variant<Ts...>& any) {
    std::uint8_t index = 0;
    Take(index);
    if (!is_good_ || index >= sizeof...(Ts)) return Fail();
    std::uint8_t next = 0;
    ((next++ == index ? void(any = TakeNew<Ts>()) : void()), ...);
  }
  template <typename T>
  requires std::is_class_v<T>
  void Take(T& value) { Visit(*this, value); }

  template <typename T>
  T New() {
    return Blank(Here(), std::type_identity<T>());
  }
  template <typename T>
  T TakeNew() {
    T value = New<T>();
    Take(value);
    return value;
  }
  /// Every item takes a byte at least, so this bounds what is allocated.
  std::size_t TakeCount() {
    std::uint32_t count = 0;
    Take(count);
    return Has(count) ? count : 0;
  }
  bool Has(std::size_t count) {
    if (bytes_.size() < count) Fail();
    return is_good_;
  }
  void Fail() { is_good_ = false; }

  std::span<const std::uint8_t> bytes_;
  bool is_good_ = true;
};

}  // namespace waymark::session::recording::internal

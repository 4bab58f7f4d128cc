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

/// Writes. Tickets, which are secrets while the session lives, go by other names.
class Writer {
 public:
  Writer(std::vector<std::uint8_t>& bytes, TicketNames* tickets)
      : bytes_(bytes), tickets_(tickets) {}

  template <typename... Ts>
  void operator()(const Ts&... values) {
    (Put(values), ...);
  }

 private:
  template <Number T>
  void Put(const T& value) {
    const auto* const begin = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), begin, begin + sizeof value);
  }
  void Put(Ticket ticket) {
    const Ticket name = tickets_ == nullptr ? ticket : tickets_->NameOf(ticket);
    Put(static_cast<std::uint64_t>(name));
  }
  void Put(const std::string& text) {
    PutCount(text.size());
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }
  template <typename Tag>
  void Put(const Id<Tag>& id) {
    Put(id.text());
  }
  template <typename Clock, typename Duration>
  void Put(const std::chrono::time_point<Clock, Duration>& instant) {
    Put(static_cast<std::int64_t>(instant.time_since_epoch().count()));
  }
  template <typename Rep, typename Period>
  void Put(const std::chrono::duration<Rep, Period>& duration) {
    Put(static_cast<std::int64_t>(duration.count()));
  }
  template <typename T, std::size_t N>
  void Put(const std::array<T, N>& items) {
    for (const T& item : items) Put(item);
  }
  template <int N>
  void Put(const Eigen::Matrix<double, N, 1>& vector) {
    for (const double value : vector) Put(value);
  }
  void Put(const Rigid3& rigid) {
    for (const double value : rigid.rotation().coeffs()) Put(value);
    Put(rigid.translation());
  }
  template <typename To, typename From>
  void Put(const Transform<To, From>& transform) {
    Put(transform.rigid());
  }
  template <typename To, typename From>
  void Put(const Similarity<To, From>& similarity) {
    Put(similarity.sim().scale());
    for (const double value : similarity.sim().rotation().coeffs()) Put(value);
    Put(Eigen::Vector3d(similarity.sim().translation()));
  }
  template <typename T>
  void Put(const std::vector<T>& items) {
    PutAll(items);
  }
  template <typename T>
  void Put(const std::set<T>& items) {
    PutAll(items);
  }
  template <typename K, typename V>
  void Put(const std::map<K, V>& items) {
    PutAll(items);
  }
  template <typename K, typename V>
  void Put(const std::pair<K, V>& pair) {
    (*this)(pair.first, pair.second);
  }
  template <typename T>
  void Put(const std::optional<T>& value) {
    Put(value.has_value());
    if (value) Put(*value);
  }
  template <typename T>
  void Put(const std::shared_ptr<const T>& value) {
    Put(value != nullptr);
    if (value) Put(*value);
  }
  template <typename T>
  void Put(const Result<T>& result) {
    Put(result.ok());
    if (result.ok()) return Put(*result);
    (*this)(result.error().code, result.error().message);
  }
  template <typename... Ts>
  void Put(const std::variant<Ts...>& any) {
    Put(static_cast<std::uint8_t>(any.index()));
    std::visit([this](const auto& value) { Put(value); }, any);
  }
  template <typename T>
  requires std::is_class_v<T>
  void Put(const T& value) { Visit(*this, const_cast<T&>(value)); }  // only reads

  template <typename Items>
  void PutAll(const Items& items) {
    PutCount(items.size());
    for (const auto& item : items) Put(item);
  }
  void PutCount(std::size_t count) { Put(static_cast<std::uint32_t>(count)); }

  std::vector<std::uint8_t>& bytes_;
  TicketNames* tickets_;
};

}  // namespace waymark::session::recording::internal

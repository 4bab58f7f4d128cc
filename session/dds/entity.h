// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <utility>

#include "mapping/base/result.h"

namespace waymark::session::dds {

/// Owns one DDS entity (domain, participant, topic, writer, …) and deletes it. Deleting a parent
/// before its children is harmless: their handles are stale by then and deleting those does
/// nothing.
class Entity {
 public:
  Entity() = default;
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Entity() { Reset(); }

  /// Takes what a dds_create_… call returned: a handle, or a negative code that becomes an error
  /// about `object`.
  static Result<Entity> Adopt(std::int32_t handle_or_code, std::string_view object);

  std::int32_t handle() const { return handle_; }
  void Reset() noexcept;

 private:
  explicit Entity(std::int32_t handle) : handle_(handle) {}

  std::int32_t handle_ = 0;
};

/// What a negative DDS return code means, for example Timeout. CHECK fails for success.
Error ErrorFromCode(std::int32_t code, std::string_view object);

}  // namespace waymark::session::dds

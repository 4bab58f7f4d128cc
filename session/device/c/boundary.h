// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
#include <utility>

#include "mapping/base/result.h"
#include "session/device/waymark_device.h"

/// What lies between C and us: nothing is believed on the way in, nothing is thrown on the way out.
namespace waymark::session::c {

/// A status with its message; an Error is one too.
struct Outcome {
  Outcome() = default;
  Outcome(const Error& error);  // NOLINT: implicit, so that WAYMARK_TRY returns it
  Outcome(const Result<void>& result)
      : Outcome(result.ok() ? Outcome() : Outcome(result.error())) {}  // NOLINT: implicit
  Outcome(WaymarkStatus refusal, std::string why) : status(refusal), message(std::move(why)) {}

  WaymarkStatus status = WAYMARK_OK;
  std::string message;
};

/// Keeps the message for the calling thread.
WaymarkStatus Answer(Outcome outcome) noexcept;
/// The message of the calling thread's latest answer.
const char* AnsweredMessage() noexcept;

/// The body of every function of the interface.
template <typename Body>
WaymarkStatus Cross(Body&& body) noexcept {
  try {
    return Answer(body());
  } catch (const std::exception& exception) {
    return Answer({WAYMARK_INTERNAL, exception.what()});
  } catch (...) {
    return Answer({WAYMARK_INTERNAL, "an exception of unknown kind"});
  }
}

/// Errors: InvalidArgument, naming the argument.
Result<void> Need(const void* argument, const char* name);
/// A text that ends within `max_bytes`. Errors: InvalidArgument.
Result<std::string> ReadText(const char* text, std::size_t max_bytes, const char* name);
/// Cuts what does not fit, and ends with NUL.
void WriteText(const std::string& text, char* out, std::size_t bytes);

/// The size that a struct had when it first appeared; to be fixed here as a number when it grows.
template <typename Struct>
inline constexpr std::size_t kFirstSize = sizeof(Struct);
template <>
inline constexpr std::size_t kFirstSize<WaymarkAnchor> = 424;
template <>
inline constexpr std::size_t kFirstSize<WaymarkOther> = 208;
template <>
inline constexpr std::size_t kFirstSize<WaymarkPlacement> = 88;
template <>
inline constexpr std::size_t kFirstSize<WaymarkStanding> = 328;

/// The `struct_size` that the app wrote. Errors: InvalidArgument.
Result<std::size_t> ReadStructSize(const void* theirs, std::size_t first_size, const char* name);
/// Errors: Unsupported when a byte behind what we know is not zero.
Result<void> NeedZeros(const void* theirs, std::size_t from, std::size_t to, const char* name);

/// A struct of the app, which may be an older, shorter form or a newer, longer one.
template <typename Struct>
Result<Struct> ReadStruct(const Struct* theirs, const char* name) {
  WAYMARK_TRY_ASSIGN(const std::size_t size, ReadStructSize(theirs, kFirstSize<Struct>, name));
  if (size > sizeof(Struct)) WAYMARK_TRY(NeedZeros(theirs, sizeof(Struct), size, name));
  Struct ours{};
  std::memcpy(&ours, theirs, std::min(size, sizeof(Struct)));
  return ours;
}

/// Fills as much of the app's struct as both know; what only the app knows becomes zero.
template <typename Struct>
void FillStruct(const Struct& ours, std::size_t their_size, void* theirs) {
  const auto size = static_cast<std::uint32_t>(their_size);
  std::memset(theirs, 0, their_size);
  std::memcpy(theirs, &ours, std::min(their_size, sizeof(Struct)));
  std::memcpy(theirs, &size, sizeof(size));
}

template <typename Struct>
Result<void> WriteStruct(const Struct& ours, Struct* theirs, const char* name) {
  WAYMARK_TRY_ASSIGN(const std::size_t size, ReadStructSize(theirs, kFirstSize<Struct>, name));
  FillStruct(ours, size, theirs);
  return {};
}

/// Fills an array whose stride is the first element's `struct_size`, and counts.
template <typename Struct, typename Values, typename Convert>
Outcome WriteArray(const Values& values, Struct* theirs, std::size_t capacity, std::size_t* count,
                   const char* name, Convert&& convert) {
  WAYMARK_TRY(Need(count, "count"));
  std::size_t size = 0;
  if (capacity > 0) {
    WAYMARK_TRY_ASSIGN(size, ReadStructSize(theirs, kFirstSize<Struct>, name));
  }
  *count = values.size();
  auto* at = reinterpret_cast<std::uint8_t*>(theirs);
  for (std::size_t i = 0; i < std::min(capacity, values.size()); ++i, at += size) {
    FillStruct(convert(values[i]), size, at);
  }
  if (values.size() <= capacity) return {};
  return {WAYMARK_TOO_SMALL,
          fmt::format("{}: there are {}, room is for {}", name, values.size(), capacity)};
}

}  // namespace waymark::session::c

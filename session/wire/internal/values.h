// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <waymark.h>  // generated from idl/waymark.idl

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory_resource>
#include <span>
#include <string>
#include <string_view>

#include "mapping/base/result.h"
#include "session/state/messages.h"

/// The pieces that messages are made of. What comes from the wire was written by anybody: every
/// Check… and Decode… returns InvalidArgument with the field's name.
namespace waymark::session::wire {

/// Memory for one encoded message; the message itself must outlive it too.
class Scratch {
 public:
  template <typename T>
  T* Allocate(std::size_t count) {
    T* const items = static_cast<T*>(memory_.allocate(count * sizeof(T), alignof(T)));
    std::uninitialized_value_construct_n(items, count);
    return items;
  }

 private:
  std::pmr::monotonic_buffer_resource memory_;
};

/// A sequence that points to memory of the scratch or of the message.
template <typename Sequence, typename T>
void PointTo(Sequence& sequence, const T* items, std::size_t count) {
  sequence._buffer =
      const_cast<T*>(items);  // the generated types know no const; writing only reads
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(count);
  sequence._release = false;
}

template <typename Sequence>
auto Items(const Sequence& sequence) {
  return std::span(sequence._buffer, sequence._buffer == nullptr ? 0 : sequence._length);
}

/// Copies into a bounded IDL string; what is too long is cut between characters.
template <std::size_t N>
void SetText(char (&field)[N], std::string_view text) {
  std::size_t length = std::min(text.size(), N - 1);
  while (length < text.size() && length > 0 && (text[length] & 0xc0) == 0x80) --length;
  std::memcpy(field, text.data(), length);
  std::memset(field + length, 0, N - length);
}

template <std::size_t N>
std::string GetText(const char (&field)[N]) {
  return std::string(field, ::strnlen(field, N));
}

void SetUuid(waymark_Uuid& field, const Uuid& uuid);
Uuid GetUuid(const waymark_Uuid& field);
/// The 16 octets of an id that is a UUID; zeros for any other text.
template <typename Tag>
void SetId(waymark_Uuid& field, const Id<Tag>& id) {
  SetUuid(field, FindUuid(id.text()).value_or(Uuid{}));
}
template <typename AnyId>
AnyId GetId(const waymark_Uuid& field) {
  return AnyId(FormatUuid(GetUuid(field)));
}

waymark_Pose EncodePose(const Rigid3& rigid);
Result<Rigid3> DecodePose(const waymark_Pose& pose, std::string_view field);
void EncodeCompactPose(const Rigid3& rigid, float (&position)[3], float (&quaternion)[4]);
Result<Rigid3> DecodeCompactPose(const float (&position)[3], const float (&quaternion)[4],
                                 std::string_view field);
waymark_GeoPosition EncodeGeo(const GeoPoint& place);
Result<GeoPoint> DecodeGeo(const waymark_GeoPosition& position, std::string_view field);
Result<CameraModel> DecodeCamera(const waymark_CameraIntrinsics& camera);

/// Finite and within [low, high].
Result<void> CheckRange(double value, double low, double high, std::string_view field);
/// UTF-8 without control characters, at most `max_bytes` long.
Result<void> CheckText(std::string_view text, std::size_t max_bytes, std::string_view field);
/// 1 to 64 of A-Z a-z 0-9 _ -: safe in partitions, paths and queries.
Result<void> CheckName(std::string_view text, std::string_view field);

/// An enumerator of ours with the same numbering as the IDL's.
template <typename Ours, typename Wire>
Result<Ours> DecodeEnum(Wire value, Ours last, std::string_view field) {
  const auto number = static_cast<std::uint32_t>(value);
  if (number > static_cast<std::uint32_t>(last)) {
    return MakeError(ErrorCode::kInvalidArgument, "{}: expected at most {}, found {}", field,
                     static_cast<std::uint32_t>(last), number);
  }
  return static_cast<Ours>(number);
}

}  // namespace waymark::session::wire

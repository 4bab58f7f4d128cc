// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <array>
#include <string>
#include <type_traits>

#include "session/wire/frames.h"
#include "session/wire/internal/codec.h"
#include "tests/support/random_geometry.h"

namespace waymark::session::wire {

inline const DeviceId kDevice{"01234567-89ab-4def-bedc-ba9876543210"};
inline const AnchorId kAnchor{"11234567-89ab-4def-bedc-ba9876543210"};
inline const SubmapId kSubmap{"00112233445566778899aabbccddeeff"};

inline Result<Upward> DecodeLike(const Upward&, std::span<const std::uint8_t> frame) {
  return DecodeUpward(frame);
}
inline Result<Downward> DecodeLike(const Downward&, std::span<const std::uint8_t> frame) {
  return DecodeDownward(frame);
}

/// Through the generated type, bytes, and back.
template <typename Message>
Result<Message> Return(const Message& message) {
  constexpr bool kIsUpward = std::is_constructible_v<Upward, Message>;
  using Any = std::conditional_t<kIsUpward, Upward, Downward>;
  const Any any(message);
  WAYMARK_TRY_ASSIGN(const Any returned, DecodeLike(any, EncodeFrame(any)));
  return std::get<Message>(returned);
}

MATCHER(IsRefused, "is refused as invalid") {
  if (arg.ok()) return false;
  *result_listener << ToString(arg.error());
  return arg.error().code == ErrorCode::kInvalidArgument;
}

inline Hello MakeHello() {
  return {.device = kDevice,
          .protocol = kProtocol,
          .attempt = 9,
          .room = RoomId("square"),
          .name = "Ännä"};
}

inline LocaliseQuery MakeQuery() {
  const std::array<double, 4> parameters{500, 510, 320, 240};
  return {.ticket = Ticket{77},
          .request = RequestNumber{5},
          .time = FromNanoseconds<DeviceTime>(123456789),
          .camera = *CameraModel::Create(CameraKind::kPinhole, 640, 480, parameters),
          .prior = GeoPrior{.position = {Angle::Degrees(52), Angle::Degrees(13), 34}, .sigma_m = 4},
          .up_in_camera = Eigen::Vector3d(0, -1, 0),
          .image = {1, 2, 3},
          .vo_from_camera = Transform<Vo, Camera>(Eigen::Quaterniond(0.6, 0, 0.8, 0), {1, 2, 3}),
          .earlier = {{RequestNumber{2}, {Eigen::Quaterniond::Identity(), {4, 5, 6}}},
                      {RequestNumber{4}, {Eigen::Quaterniond::Identity(), {7, 8, 9}}}}};
}

inline AnchorCommand MakeCommand(waymark::support::RandomGeometry& random) {
  return {.ticket = Ticket{77},
          .request = UuidFromBits(1, 2),
          .operation = AnchorOperation::kMove,
          .anchor = kAnchor,
          .expected_revision = 12,
          .epoch = 3,
          .map_from_anchor = Transform<Map, Anchor>(random.Rigid()),
          .seen_in = {kSubmap},
          .kind = "note",
          .payload = std::string("\0\x01 bytes", 8)};
}

}  // namespace waymark::session::wire

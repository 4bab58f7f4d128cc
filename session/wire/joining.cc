// SPDX-License-Identifier: Apache-2.0
#include "session/wire/internal/codec.h"

namespace waymark::session::wire {

waymark_Hello Encode(const Hello& hello, Scratch&) {
  waymark_Hello wire{};
  SetId(wire.device, hello.device);
  wire.protocol = hello.protocol;
  wire.attempt = hello.attempt;
  SetText(wire.room, hello.room.text());
  SetText(wire.name, hello.name);
  SetText(wire.token, hello.token);
  SetText(wire.owner_secret, hello.owner_secret);
  wire.anchor_scope = static_cast<waymark_AnchorScope>(hello.anchor_scope);
  return wire;
}

// What a device may ask wrongly is decided by the state, which can answer; only what is dangerous
// is dropped here.
Result<Hello> Decode(const waymark_Hello& wire) {
  WAYMARK_TRY_ASSIGN(const AnchorScope scope,
                     DecodeEnum(wire.anchor_scope, AnchorScope::kArea, "anchor scope"));
  Hello hello{.device = GetId<DeviceId>(wire.device),
              .protocol = wire.protocol,
              .attempt = wire.attempt,
              .room = RoomId(GetText(wire.room)),
              .name = GetText(wire.name),
              .token = GetText(wire.token),
              .owner_secret = GetText(wire.owner_secret),
              .anchor_scope = scope};
  WAYMARK_TRY(CheckName(hello.room.text(), "room"));
  WAYMARK_TRY(CheckText(hello.name, kMaxNameBytes, "device name"));
  return hello;
}

waymark_Welcome Encode(const Welcome& welcome, Scratch&) {
  waymark_Welcome wire{};
  SetId(wire.device, welcome.device);
  wire.attempt = welcome.attempt;
  wire.verdict = static_cast<waymark_JoinVerdict>(welcome.verdict);
  SetText(wire.reason, welcome.reason);
  wire.run = static_cast<std::uint64_t>(welcome.run);
  wire.ticket = static_cast<std::uint64_t>(welcome.ticket);
  wire.number = static_cast<std::uint32_t>(welcome.number);
  SetText(wire.map_uuid, welcome.map.map);
  wire.is_geo_aligned = welcome.map.is_geo_aligned;
  wire.origin = EncodeGeo(welcome.map.origin);
  wire.epoch = welcome.map.epoch;
  wire.session_time_ns = ToNanoseconds(welcome.session_time);
  wire.role = static_cast<waymark_Role>(welcome.role);
  wire.is_return = welcome.is_return;
  wire.protocol = welcome.protocol;
  SetText(wire.owner, welcome.owner);
  return wire;
}

Result<Welcome> Decode(const waymark_Welcome& wire) {
  WAYMARK_TRY_ASSIGN(const JoinVerdict verdict,
                     DecodeEnum(wire.verdict, JoinVerdict::kRemoved, "verdict"));
  WAYMARK_TRY_ASSIGN(const Role role, DecodeEnum(wire.role, Role::kModerator, "role"));
  WAYMARK_TRY_ASSIGN(const GeoPoint origin, DecodeGeo(wire.origin, "map origin"));
  return Welcome{.device = GetId<DeviceId>(wire.device),
                 .attempt = wire.attempt,
                 .verdict = verdict,
                 .reason = GetText(wire.reason),
                 .run = RunId{wire.run},
                 .ticket = Ticket{wire.ticket},
                 .number = DeviceNumber{wire.number},
                 .map = {.map = GetText(wire.map_uuid),
                         .is_geo_aligned = wire.is_geo_aligned,
                         .origin = origin,
                         .epoch = wire.epoch},
                 .session_time = FromNanoseconds<ServerTime>(wire.session_time_ns),
                 .role = role,
                 .is_return = wire.is_return,
                 .protocol = std::max(wire.protocol, std::uint32_t{1}),
                 .owner = GetText(wire.owner)};
}

waymark_Presence Encode(const Presence& presence, Scratch&) {
  waymark_Presence wire{};
  SetId(wire.device, presence.device);
  wire.number = static_cast<std::uint32_t>(presence.number);
  SetText(wire.name, presence.name);
  wire.run = static_cast<std::uint64_t>(presence.run);
  wire.role = static_cast<waymark_Role>(presence.role);
  return wire;
}

Result<Presence> Decode(const waymark_Presence& wire) {
  WAYMARK_TRY_ASSIGN(const Role role, DecodeEnum(wire.role, Role::kModerator, "role"));
  Presence presence{.device = GetId<DeviceId>(wire.device),
                    .number = DeviceNumber{wire.number},
                    .name = GetText(wire.name),
                    .run = RunId{wire.run},
                    .role = role};
  WAYMARK_TRY(CheckText(presence.name, kMaxNameBytes, "device name"));
  return presence;
}

waymark_RoomCommand Encode(const RoomCommand& command, Scratch&) {
  waymark_RoomCommand wire{};
  wire.ticket = static_cast<std::uint64_t>(command.ticket);
  SetUuid(wire.request, command.request);
  wire.operation = static_cast<waymark_RoomOperation>(command.operation);
  SetId(wire.device, command.device);
  wire.capacity = command.capacity;
  SetText(wire.reason, command.reason);
  return wire;
}

Result<RoomCommand> Decode(const waymark_RoomCommand& wire) {
  WAYMARK_TRY_ASSIGN(const RoomOperation operation,
                     DecodeEnum(wire.operation, RoomOperation::kSetCapacity, "room operation"));
  RoomCommand command{.ticket = Ticket{wire.ticket},
                      .request = GetUuid(wire.request),
                      .operation = operation,
                      .device = GetId<DeviceId>(wire.device),
                      .capacity = wire.capacity,
                      .reason = GetText(wire.reason)};
  WAYMARK_TRY(CheckText(command.reason, kMaxReasonBytes, "reason"));
  return command;
}

waymark_ClockPing Encode(const ClockPing& ping, Scratch&) {
  return {.ticket = static_cast<std::uint64_t>(ping.ticket),
          .sequence_number = ping.sequence_number,
          .device_sent_ns = ToNanoseconds(ping.sent)};
}

Result<ClockPing> Decode(const waymark_ClockPing& wire) {
  return ClockPing{.ticket = Ticket{wire.ticket},
                   .sequence_number = wire.sequence_number,
                   .sent = FromNanoseconds<DeviceTime>(wire.device_sent_ns)};
}

waymark_ClockPong Encode(const ClockPong& pong, Scratch&) {
  waymark_ClockPong wire{};
  SetId(wire.device, pong.device);
  wire.sequence_number = pong.sequence_number;
  wire.device_sent_ns = ToNanoseconds(pong.device_sent);
  wire.session_received_ns = ToNanoseconds(pong.received);
  wire.session_sent_ns = ToNanoseconds(pong.sent);
  wire.run = static_cast<std::uint64_t>(pong.run);
  return wire;
}

Result<ClockPong> Decode(const waymark_ClockPong& wire) {
  return ClockPong{.device = GetId<DeviceId>(wire.device),
                   .sequence_number = wire.sequence_number,
                   .device_sent = FromNanoseconds<DeviceTime>(wire.device_sent_ns),
                   .received = FromNanoseconds<ServerTime>(wire.session_received_ns),
                   .sent = FromNanoseconds<ServerTime>(wire.session_sent_ns),
                   .run = RunId{wire.run}};
}

}  // namespace waymark::session::wire

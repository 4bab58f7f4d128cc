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
  return wire;
}

// What a device may ask wrongly is decided by the state, which can answer; only what is dangerous
// is dropped here.
Result<Hello> Decode(const waymark_Hello& wire) {
  Hello hello{.device = GetId<DeviceId>(wire.device),
              .protocol = wire.protocol,
              .attempt = wire.attempt,
              .room = RoomId(GetText(wire.room)),
              .name = GetText(wire.name)};
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
  return wire;
}

Result<Welcome> Decode(const waymark_Welcome& wire) {
  WAYMARK_TRY_ASSIGN(const JoinVerdict verdict,
                     DecodeEnum(wire.verdict, JoinVerdict::kUnavailable, "verdict"));
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
                 .session_time = FromNanoseconds<ServerTime>(wire.session_time_ns)};
}

waymark_Presence Encode(const Presence& presence, Scratch&) {
  waymark_Presence wire{};
  SetId(wire.device, presence.device);
  wire.number = static_cast<std::uint32_t>(presence.number);
  SetText(wire.name, presence.name);
  wire.run = static_cast<std::uint64_t>(presence.run);
  return wire;
}

Result<Presence> Decode(const waymark_Presence& wire) {
  Presence presence{.device = GetId<DeviceId>(wire.device),
                    .number = DeviceNumber{wire.number},
                    .name = GetText(wire.name),
                    .run = RunId{wire.run}};
  WAYMARK_TRY(CheckText(presence.name, kMaxNameBytes, "device name"));
  return presence;
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

// SPDX-License-Identifier: Apache-2.0
#include "session/wire/internal/codec.h"

namespace waymark::session::wire {
namespace {

Result<AnchorArea> DecodeArea(const double (&centre_m)[2], double radius_m) {
  for (const double coordinate : centre_m) {
    WAYMARK_TRY(CheckRange(coordinate, -kMaxCoordinate_m, kMaxCoordinate_m, "map_centre_m"));
  }
  WAYMARK_TRY(CheckRange(radius_m, 0, kMaxAreaRadius_m, "radius_m"));
  return AnchorArea{{centre_m[0], centre_m[1]}, radius_m};
}

}  // namespace

waymark_AreaReport Encode(const AreaReport& report, Scratch&) {
  waymark_AreaReport wire{};
  wire.ticket = static_cast<std::uint64_t>(report.ticket);
  wire.number = report.number;
  Eigen::Map<Eigen::Vector2d>(wire.map_centre_m) = report.area.centre_m;
  wire.radius_m = report.area.radius_m;
  wire.is_anew = report.is_anew;
  return wire;
}

Result<AreaReport> Decode(const waymark_AreaReport& wire) {
  WAYMARK_TRY_ASSIGN(const AnchorArea area, DecodeArea(wire.map_centre_m, wire.radius_m));
  return AreaReport{
      .ticket = Ticket{wire.ticket}, .number = wire.number, .area = area, .is_anew = wire.is_anew};
}

waymark_AreaState Encode(const AreaState& state, Scratch&) {
  waymark_AreaState wire{};
  SetId(wire.device, state.device);
  wire.run = static_cast<std::uint64_t>(state.run);
  wire.number = state.number;
  Eigen::Map<Eigen::Vector2d>(wire.map_centre_m) = state.area.centre_m;
  wire.radius_m = state.area.radius_m;
  wire.anchor_count = state.anchor_count;
  wire.anchor_digest = state.anchor_digest;
  return wire;
}

Result<AreaState> Decode(const waymark_AreaState& wire) {
  WAYMARK_TRY_ASSIGN(const AnchorArea area, DecodeArea(wire.map_centre_m, wire.radius_m));
  return AreaState{.device = GetId<DeviceId>(wire.device),
                   .run = RunId{wire.run},
                   .number = wire.number,
                   .area = area,
                   .anchor_count = wire.anchor_count,
                   .anchor_digest = wire.anchor_digest};
}

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#include "session/wire/internal/codec.h"

namespace waymark::session::wire {

waymark_MapState Encode(const MapState& state, Scratch& scratch) {
  waymark_MapState wire{};
  SetText(wire.room, state.room.text());
  wire.run = static_cast<std::uint64_t>(state.run);
  wire.swap = state.swap;
  wire.epoch = state.epoch;
  const std::size_t count = std::min(state.placements.size(), kMaxPlacements);
  auto* const placements = scratch.Allocate<waymark_SubmapPlacement>(count);
  std::size_t i = 0;
  for (const auto& [submap, map_from_submap] : state.placements) {
    if (i == count) break;
    SetText(placements[i].submap, submap.text());
    const Sim3& sim = map_from_submap.sim();
    placements[i].scale = sim.scale();
    placements[i].map_from_submap = EncodePose(Rigid3(sim.rotation(), sim.translation()));
    ++i;
  }
  PointTo(wire.placements, placements, count);
  return wire;
}

Result<MapState> Decode(const waymark_MapState& wire) {
  constexpr double kMaxScale = 1e6;
  MapState state{.room = RoomId(GetText(wire.room)),
                 .run = RunId{wire.run},
                 .swap = wire.swap,
                 .epoch = wire.epoch};
  WAYMARK_TRY(CheckName(state.room.text(), "room"));
  const auto placements = Items(wire.placements);
  WAYMARK_TRY(CheckRange(static_cast<double>(placements.size()), 0,
                         static_cast<double>(kMaxPlacements), "placements"));
  for (const waymark_SubmapPlacement& placement : placements) {
    const SubmapId submap(GetText(placement.submap));
    WAYMARK_TRY(CheckName(submap.text(), "placement's submap"));
    WAYMARK_TRY(CheckRange(placement.scale, 1 / kMaxScale, kMaxScale, "scale"));
    WAYMARK_TRY_ASSIGN(const Rigid3 pose, DecodePose(placement.map_from_submap, "map_from_submap"));
    state.placements.emplace(submap, Similarity<Map, Submap>(Sim3(placement.scale, pose.rotation(),
                                                                  pose.translation())));
  }
  return state;
}

}  // namespace waymark::session::wire

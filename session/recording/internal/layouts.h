// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/recording/internal/effect_layouts.h"
#include "session/recording/internal/event_layouts.h"
#include "session/recording/recording.h"

/// What recorded values are made of, in order. The bindings name every member, so that one more
/// does not compile until it is here, which makes another version of the format.
namespace waymark::session::recording::internal {

template <typename Archive>
void Visit(Archive& archive, StateOptions& value) {
  auto& [presence, return_within, ban, room_idle, pose_repeat, clock_error, rooms, members, anchors,
         told_anchors, own_anchors, writes, rules, rights, opening] = value;
  archive(presence, return_within, ban, room_idle, pose_repeat, clock_error, rooms, members,
          anchors, told_anchors, own_anchors, writes, rules, rights, opening);
}

template <typename Archive>
void Visit(Archive& archive, RecordingHeader& value) {
  auto& [options, run, map, placements, started] = value;
  archive(options, run, map, placements, started);
}

}  // namespace waymark::session::recording::internal

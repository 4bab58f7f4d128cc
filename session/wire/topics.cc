// SPDX-License-Identifier: Apache-2.0
#include "session/wire/internal/topics.h"

namespace waymark::session::wire {

using dds::Delivery;
using dds::History;
using dds::Topic;

// The digit is the version of the type; changing a final one means a new digit.

template <>
Topic TopicOf<Hello>() {
  return {"waymark/1/hello", &waymark_Hello_desc, Delivery::kReliable, History::kNone, 1};
}
template <>
Topic TopicOf<RoomCommand>() {
  return {"waymark/1/room_command", &waymark_RoomCommand_desc, Delivery::kReliable, History::kNone,
          8};
}
template <>
Topic TopicOf<Welcome>() {
  return {"waymark/1/welcome", &waymark_Welcome_desc, Delivery::kReliable, History::kForLateJoiners,
          1};
}
template <>
Topic TopicOf<Presence>() {
  return {"waymark/1/presence", &waymark_Presence_desc, Delivery::kReliable,
          History::kForLateJoiners, 1};
}
template <>
Topic TopicOf<PoseReport>() {
  return {"waymark/3/pose_report", &waymark_PoseReport_desc, Delivery::kBestEffort, History::kNone,
          1};
}
template <>
Topic TopicOf<PoseBatch>() {
  return {"waymark/3/pose_batch", &waymark_PoseBatch_desc, Delivery::kBestEffort, History::kNone,
          1};
}
template <>
Topic TopicOf<LocaliseQuery>() {
  return {"waymark/1/localise_query", &waymark_LocaliseQuery_desc, Delivery::kReliable,
          History::kNone, 1};
}
template <>
Topic TopicOf<LocaliseAnswer>() {
  return {"waymark/1/localise_answer", &waymark_LocaliseAnswer_desc, Delivery::kReliable,
          History::kForLateJoiners, 2};
}
template <>
Topic TopicOf<AnchorState>() {
  return {"waymark/1/anchor", &waymark_AnchorState_desc, Delivery::kReliable,
          History::kForLateJoiners, 1};
}
template <>
Topic TopicOf<AnchorCommand>() {
  return {"waymark/1/anchor_command", &waymark_AnchorCommand_desc, Delivery::kReliable,
          History::kNone, 32};
}
template <>
Topic TopicOf<CommandReply>() {
  return {"waymark/1/command_reply", &waymark_CommandReply_desc, Delivery::kReliable,
          History::kForLateJoiners, 32};
}
template <>
Topic TopicOf<RoomState>() {
  return {"waymark/1/room_state", &waymark_RoomState_desc, Delivery::kReliable,
          History::kForLateJoiners, 1};
}
template <>
Topic TopicOf<OwnerState>() {
  return {"waymark/1/owner_state", &waymark_OwnerState_desc, Delivery::kReliable,
          History::kForLateJoiners, 1};
}
template <>
Topic TopicOf<AreaReport>() {
  return {"waymark/1/area_report", &waymark_AreaReport_desc, Delivery::kReliable, History::kNone,
          1};
}
template <>
Topic TopicOf<AreaState>() {
  return {"waymark/1/area_state", &waymark_AreaState_desc, Delivery::kReliable,
          History::kForLateJoiners, 1};
}
Topic AreaAnchorTopic() {
  return {"waymark/1/area_anchor", &waymark_AnchorState_desc, Delivery::kReliable,
          History::kForLateJoiners, 1};
}
template <>
Topic TopicOf<MapState>() {
  return {"waymark/1/map_state", &waymark_MapState_desc, Delivery::kReliable,
          History::kForLateJoiners, 1};
}
template <>
Topic TopicOf<ClockPing>() {
  return {"waymark/1/clock_ping", &waymark_ClockPing_desc, Delivery::kBestEffort, History::kNone,
          1};
}
template <>
Topic TopicOf<ClockPong>() {
  return {"waymark/1/clock_pong", &waymark_ClockPong_desc, Delivery::kBestEffort, History::kNone,
          1};
}
template <>
Topic TopicOf<GatewayReport>() {
  return {"waymark/1/gateway_report", &waymark_GatewayReport_desc, Delivery::kBestEffort,
          History::kNone, 1};
}
template <>
Topic TopicOf<GatewayPongs>() {
  return {"waymark/1/gateway_pongs", &waymark_GatewayPongs_desc, Delivery::kBestEffort,
          History::kNone, 1};
}

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/wire/internal/values.h"

/// Messages to generated types and back. `Encode` borrows from the message and the scratch;
/// `Decode` copies and checks everything: InvalidArgument with the field's name.
namespace waymark::session::wire {

waymark_Hello Encode(const Hello& hello, Scratch& scratch);
Result<Hello> Decode(const waymark_Hello& wire);
waymark_RoomCommand Encode(const RoomCommand& command, Scratch& scratch);
Result<RoomCommand> Decode(const waymark_RoomCommand& wire);
waymark_Welcome Encode(const Welcome& welcome, Scratch& scratch);
Result<Welcome> Decode(const waymark_Welcome& wire);
waymark_Presence Encode(const Presence& presence, Scratch& scratch);
Result<Presence> Decode(const waymark_Presence& wire);

waymark_PoseReport Encode(const PoseReport& report, Scratch& scratch);
Result<PoseReport> Decode(const waymark_PoseReport& wire);
waymark_PoseBatch Encode(const PoseBatch& batch, Scratch& scratch);
Result<PoseBatch> Decode(const waymark_PoseBatch& wire);

waymark_LocaliseQuery Encode(const LocaliseQuery& query, Scratch& scratch);
Result<LocaliseQuery> Decode(const waymark_LocaliseQuery& wire);
waymark_LocaliseAnswer Encode(const LocaliseAnswer& answer, Scratch& scratch);
Result<LocaliseAnswer> Decode(const waymark_LocaliseAnswer& wire);

waymark_AnchorState Encode(const AnchorState& state, Scratch& scratch);
Result<AnchorState> Decode(const waymark_AnchorState& wire);
waymark_AnchorCommand Encode(const AnchorCommand& command, Scratch& scratch);
Result<AnchorCommand> Decode(const waymark_AnchorCommand& wire);
waymark_CommandReply Encode(const CommandReply& reply, Scratch& scratch);
Result<CommandReply> Decode(const waymark_CommandReply& wire);
waymark_RoomState Encode(const RoomState& state, Scratch& scratch);
Result<RoomState> Decode(const waymark_RoomState& wire);
waymark_OwnerState Encode(const OwnerState& state, Scratch& scratch);
Result<OwnerState> Decode(const waymark_OwnerState& wire);
waymark_AreaReport Encode(const AreaReport& report, Scratch& scratch);
Result<AreaReport> Decode(const waymark_AreaReport& wire);
waymark_AreaState Encode(const AreaState& state, Scratch& scratch);
Result<AreaState> Decode(const waymark_AreaState& wire);

/// Names an anchor that is over, in what only its key counts of; private: for its owner.
waymark_AnchorState AnchorKey(const AnchorId& anchor, bool is_private);
bool IsPrivate(const waymark_AnchorState& wire);

waymark_MapState Encode(const MapState& state, Scratch& scratch);
Result<MapState> Decode(const waymark_MapState& wire);

waymark_ClockPing Encode(const ClockPing& ping, Scratch& scratch);
Result<ClockPing> Decode(const waymark_ClockPing& wire);
waymark_ClockPong Encode(const ClockPong& pong, Scratch& scratch);
Result<ClockPong> Decode(const waymark_ClockPong& wire);

waymark_GatewayReport Encode(const GatewayReport& report, Scratch& scratch);
Result<GatewayReport> Decode(const waymark_GatewayReport& wire);
waymark_GatewayPongs Encode(const GatewayPongs& pongs, Scratch& scratch);
Result<GatewayPongs> Decode(const waymark_GatewayPongs& wire);

/// The generated type of a message.
template <typename Message>
using WireOf = decltype(Encode(std::declval<const Message&>(), std::declval<Scratch&>()));

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#include "session/wire/internal/codec.h"

namespace waymark::session::wire {
namespace {

std::string GetBytes(std::span<const std::uint8_t> bytes) {
  return std::string(bytes.begin(), bytes.end());
}

template <typename Sequence>
void PointToBytes(Sequence& sequence, std::string_view bytes) {
  PointTo(sequence, reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

Result<void> CheckCount(std::size_t count, std::size_t max_count, std::string_view field) {
  return CheckRange(static_cast<double>(count), 0, static_cast<double>(max_count), field);
}

// The room's is the wire's 0: what an older writer leaves out.
waymark_AnchorAudience EncodeAudience(content::AnchorVisibility visibility) {
  switch (visibility) {
    case content::AnchorVisibility::kPrivate:
      return waymark_AUDIENCE_PRIVATE;
    case content::AnchorVisibility::kPublic:
      return waymark_AUDIENCE_PUBLIC;
    case content::AnchorVisibility::kRoom:
      break;
  }
  return waymark_AUDIENCE_ROOM;
}

Result<content::AnchorVisibility> DecodeAudience(waymark_AnchorAudience audience) {
  switch (audience) {
    case waymark_AUDIENCE_ROOM:
      return content::AnchorVisibility::kRoom;
    case waymark_AUDIENCE_PRIVATE:
      return content::AnchorVisibility::kPrivate;
    case waymark_AUDIENCE_PUBLIC:
      return content::AnchorVisibility::kPublic;
  }
  return MakeError(ErrorCode::kInvalidArgument, "audience: expected room, private or public");
}

waymark_AnchorContent EncodeContent(const RoomAnchor& anchor, Scratch& scratch) {
  const content::AnchorRecord& record = anchor.record;
  waymark_AnchorContent wire{};
  SetText(wire.owner, record.owner);
  wire.revision = record.revision;
  wire.epoch = record.epoch;
  wire.is_supported = anchor.is_supported;
  wire.map_from_anchor = EncodePose(record.map_from_anchor.rigid());
  const std::size_t count = std::min(record.attachments.size(), kMaxAttachments);
  auto* const attachments = scratch.Allocate<waymark_SubmapAttachment>(count);
  for (std::size_t i = 0; i < count; ++i) {
    SetText(attachments[i].submap, record.attachments[i].submap.text());
    attachments[i].submap_from_anchor =
        EncodePose(record.attachments[i].submap_from_anchor.rigid());
  }
  PointTo(wire.attachments, attachments, count);
  SetText(wire.kind, record.kind);
  PointToBytes(wire.payload, record.payload);
  wire.audience = EncodeAudience(record.visibility);
  return wire;
}

Result<RoomAnchor> DecodeContent(const waymark_AnchorContent& wire, const AnchorId& anchor) {
  WAYMARK_TRY_ASSIGN(const Rigid3 map_from_anchor,
                     DecodePose(wire.map_from_anchor, "map_from_anchor"));
  const auto payload = Items(wire.payload);
  const auto attachments = Items(wire.attachments);
  WAYMARK_TRY_ASSIGN(const auto visibility, DecodeAudience(wire.audience));
  WAYMARK_TRY(CheckCount(payload.size(), kMaxPayloadBytes, "payload bytes"));
  WAYMARK_TRY(CheckCount(attachments.size(), kMaxAttachments, "attachments"));
  RoomAnchor result{.record = {.id = anchor,
                               .room = RoomId(""),
                               .owner = GetText(wire.owner),
                               .map_from_anchor = Transform<Map, Anchor>(map_from_anchor),
                               .epoch = wire.epoch,
                               .attachments = {},
                               .place = {},
                               .kind = GetText(wire.kind),
                               .payload = GetBytes(payload),
                               .revision = wire.revision,
                               .visibility = visibility},
                    .is_supported = wire.is_supported};
  for (const waymark_SubmapAttachment& attachment : attachments) {
    const SubmapId submap(GetText(attachment.submap));
    WAYMARK_TRY(CheckName(submap.text(), "attachment's submap"));
    WAYMARK_TRY_ASSIGN(const Rigid3 submap_from_anchor,
                       DecodePose(attachment.submap_from_anchor, "submap_from_anchor"));
    result.record.attachments.push_back({submap, Transform<Submap, Anchor>(submap_from_anchor)});
  }
  return result;
}

}  // namespace

waymark_AnchorState Encode(const AnchorState& state, Scratch& scratch) {
  waymark_AnchorState wire{};
  SetId(wire.anchor, state.anchor.record.id);
  wire.run = static_cast<std::uint64_t>(state.run);
  wire.content = EncodeContent(state.anchor, scratch);
  return wire;
}

Result<AnchorState> Decode(const waymark_AnchorState& wire) {
  WAYMARK_TRY_ASSIGN(RoomAnchor anchor, DecodeContent(wire.content, GetId<AnchorId>(wire.anchor)));
  return AnchorState{.run = RunId{wire.run}, .anchor = std::move(anchor)};
}

waymark_AnchorState AnchorKey(const AnchorId& anchor, bool is_private) {
  waymark_AnchorState key{};
  SetId(key.anchor, anchor);
  if (is_private) key.content.audience = waymark_AUDIENCE_PRIVATE;
  return key;
}

bool IsPrivate(const waymark_AnchorState& wire) {
  return wire.content.audience == waymark_AUDIENCE_PRIVATE;
}

waymark_AnchorCommand Encode(const AnchorCommand& command, Scratch& scratch) {
  waymark_AnchorCommand wire{};
  wire.ticket = static_cast<std::uint64_t>(command.ticket);
  SetUuid(wire.request, command.request);
  wire.operation = static_cast<waymark_AnchorOperation>(command.operation);
  SetId(wire.anchor, command.anchor);
  wire.expected_revision = command.expected_revision;
  wire.epoch = command.epoch;
  wire.map_from_anchor = EncodePose(command.map_from_anchor.rigid());
  const std::size_t count = std::min(command.seen_in.size(), kMaxAttachments);
  auto* const submaps = scratch.Allocate<waymark_SubmapName>(count);
  for (std::size_t i = 0; i < count; ++i) SetText(submaps[i].submap, command.seen_in[i].text());
  PointTo(wire.seen_in, submaps, count);
  SetText(wire.kind, command.kind);
  PointToBytes(wire.payload, command.payload);
  wire.audience = EncodeAudience(command.visibility);
  return wire;
}

Result<AnchorCommand> Decode(const waymark_AnchorCommand& wire) {
  WAYMARK_TRY_ASSIGN(const AnchorOperation operation,
                     DecodeEnum(wire.operation, AnchorOperation::kDelete, "operation"));
  WAYMARK_TRY_ASSIGN(const Rigid3 map_from_anchor,
                     DecodePose(wire.map_from_anchor, "map_from_anchor"));
  const auto payload = Items(wire.payload);
  WAYMARK_TRY(CheckCount(payload.size(), kMaxPayloadBytes, "payload bytes"));
  WAYMARK_TRY(CheckCount(Items(wire.seen_in).size(), kMaxAttachments, "submaps"));
  WAYMARK_TRY_ASSIGN(const auto visibility, DecodeAudience(wire.audience));
  AnchorCommand command{.ticket = Ticket{wire.ticket},
                        .request = GetUuid(wire.request),
                        .operation = operation,
                        .anchor = GetId<AnchorId>(wire.anchor),
                        .expected_revision = wire.expected_revision,
                        .epoch = wire.epoch,
                        .map_from_anchor = Transform<Map, Anchor>(map_from_anchor),
                        .seen_in = {},
                        .kind = GetText(wire.kind),
                        .payload = GetBytes(payload),
                        .visibility = visibility};
  WAYMARK_TRY(CheckText(command.kind, kMaxKindBytes, "kind"));
  for (const waymark_SubmapName& name : Items(wire.seen_in)) {
    command.seen_in.emplace_back(GetText(name.submap));
    WAYMARK_TRY(CheckName(command.seen_in.back().text(), "submap"));
  }
  return command;
}

waymark_CommandReply Encode(const CommandReply& reply, Scratch& scratch) {
  waymark_CommandReply wire{};
  SetId(wire.device, reply.device);
  SetUuid(wire.request, reply.request);
  wire.outcome = static_cast<waymark_CommandOutcome>(reply.outcome);
  SetText(wire.reason, reply.reason);
  SetId(wire.anchor, reply.anchor);
  if (reply.current) {
    wire.current = scratch.Allocate<waymark_AnchorContent>(1);
    *wire.current = EncodeContent(*reply.current, scratch);
  }
  return wire;
}

Result<CommandReply> Decode(const waymark_CommandReply& wire) {
  WAYMARK_TRY_ASSIGN(const CommandOutcome outcome,
                     DecodeEnum(wire.outcome, CommandOutcome::kForbidden, "outcome"));
  CommandReply reply{.device = GetId<DeviceId>(wire.device),
                     .request = GetUuid(wire.request),
                     .outcome = outcome,
                     .reason = GetText(wire.reason),
                     .anchor = GetId<AnchorId>(wire.anchor),
                     .current = std::nullopt};
  if (wire.current != nullptr) {
    WAYMARK_TRY_ASSIGN(reply.current, DecodeContent(*wire.current, reply.anchor));
  }
  return reply;
}

waymark_RoomState Encode(const RoomState& state, Scratch&) {
  waymark_RoomState wire{};
  SetText(wire.room, state.room.text());
  wire.run = static_cast<std::uint64_t>(state.run);
  wire.revision = state.revision;
  wire.epoch = state.epoch;
  wire.anchor_count = state.anchor_count;
  wire.anchor_digest = state.anchor_digest;
  return wire;
}

Result<RoomState> Decode(const waymark_RoomState& wire) {
  RoomState state{.room = RoomId(GetText(wire.room)),
                  .run = RunId{wire.run},
                  .revision = wire.revision,
                  .epoch = wire.epoch,
                  .anchor_count = wire.anchor_count,
                  .anchor_digest = wire.anchor_digest};
  WAYMARK_TRY(CheckName(state.room.text(), "room"));
  return state;
}

waymark_OwnerState Encode(const OwnerState& state, Scratch&) {
  waymark_OwnerState wire{};
  SetText(wire.owner, state.owner);
  wire.run = static_cast<std::uint64_t>(state.run);
  wire.anchor_count = state.anchor_count;
  wire.anchor_digest = state.anchor_digest;
  return wire;
}

Result<OwnerState> Decode(const waymark_OwnerState& wire) {
  OwnerState state{.owner = GetText(wire.owner),
                   .run = RunId{wire.run},
                   .anchor_count = wire.anchor_count,
                   .anchor_digest = wire.anchor_digest};
  WAYMARK_TRY(CheckText(state.owner, kMaxNameBytes, "owner"));
  return state;
}

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
// Our bytes are those of the standard: Cyclone's serialiser writes the same.
#include "session/wire/internal/cdr_reader.h"
#include "session/wire/internal/cdr_writer.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsi/q_protocol.h>

#include "session/wire/internal/layouts.h"
#include "tests/session/wire_fixture.h"

namespace waymark::session::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <typename Wire>
Bytes WriteOurs(const Wire& wire) {
  Bytes bytes;
  CdrWriter writer(bytes);
  writer(wire);
  return bytes;
}

template <typename Wire>
Bytes WriteCyclone(const Wire& wire, const dds_topic_descriptor_t& type) {
  dds_ostreamLE_t stream;
  dds_ostreamLE_init(&stream, 256, CDR_ENC_VERSION_2);
  (void)dds_stream_writeLE(&stream, reinterpret_cast<const char*>(&wire), type.m_ops);
  Bytes bytes(stream.x.m_buffer, stream.x.m_buffer + stream.x.m_index);
  dds_ostreamLE_fini(&stream);
  return bytes;
}

template <typename Message>
void ExpectSameBytes(const Message& message, const dds_topic_descriptor_t& type) {
  Scratch scratch;
  const auto wire = Encode(message, scratch);
  EXPECT_EQ(WriteOurs(wire), WriteCyclone(wire, type)) << type.m_typename;
}

TEST(Cdr, WritesWhatCycloneWrites) {
  support::RandomGeometry random(1);
  const LivePose pose{.time = {}, .map_from_device = Transform<Map, Device>(random.Rigid())};
  ExpectSameBytes(MakeHello(), waymark_Hello_desc);
  ExpectSameBytes(PoseReport{Ticket{7}, pose}, waymark_PoseReport_desc);
  ExpectSameBytes(MakeQuery(), waymark_LocaliseQuery_desc);
  LocaliseQuery bare = MakeQuery();
  bare.prior.reset();
  bare.up_in_camera.reset();
  bare.vo_from_camera.reset();
  bare.earlier.clear();
  ExpectSameBytes(bare, waymark_LocaliseQuery_desc);
  ExpectSameBytes(MakeCommand(random), waymark_AnchorCommand_desc);
  ExpectSameBytes(ClockPing{Ticket{7}, 3, {}}, waymark_ClockPing_desc);

  Welcome welcome{.device = kDevice, .reason = "full"};
  welcome.map.map = "a map";
  ExpectSameBytes(welcome, waymark_Welcome_desc);
  ExpectSameBytes(Presence{.device = kDevice, .name = "Ännä"}, waymark_Presence_desc);
  PoseBatch batch;
  for (std::uint32_t i = 0; i < 5; ++i) batch.poses.push_back({DeviceNumber{i}, pose});
  ExpectSameBytes(batch, waymark_PoseBatch_desc);
  ExpectSameBytes(ClockPong{.device = kDevice}, waymark_ClockPong_desc);
  ExpectSameBytes(RoomState{.room = RoomId("square")}, waymark_RoomState_desc);
  ExpectSameBytes(
      AreaReport{.ticket = Ticket{7}, .number = 3, .area = {{1.5, -2}, 90}, .is_anew = true},
      waymark_AreaReport_desc);
  ExpectSameBytes(AreaState{.device = kDevice,
                            .run = RunId{3},
                            .number = 4,
                            .area = {{1, 2}, 3},
                            .anchor_count = 5,
                            .anchor_digest = 6},
                  waymark_AreaState_desc);
  ExpectSameBytes(OwnerState{.owner = "@0", .run = RunId{3}, .anchor_count = 2},
                  waymark_OwnerState_desc);
}

TEST(Cdr, WritesNestedThingsAsCycloneDoes) {
  support::RandomGeometry random(2);
  LocaliseAnswer answer{.device = kDevice, .reason = "busy"};
  ExpectSameBytes(answer, waymark_LocaliseAnswer_desc);
  answer.status = LocaliseStatus::kLocalised;
  answer.pose =
      localiser::LocalisedPose{.map_from_camera = Transform<Map, Camera>(random.Rigid()),
                               .covariance = Eigen::Matrix<double, 6, 6>::Identity(),
                               .submap = kSubmap,
                               .submap_from_camera = Transform<Submap, Camera>(random.Rigid()),
                               .inliers = 30,
                               .rms_px = 1.5};
  ExpectSameBytes(answer, waymark_LocaliseAnswer_desc);

  const RoomAnchor anchor{
      .record = {.id = kAnchor,
                 .room = RoomId(""),
                 .owner = kDevice.text(),
                 .map_from_anchor = Transform<Map, Anchor>(random.Rigid()),
                 .attachments = {{kSubmap, Transform<Submap, Anchor>(random.Rigid())},
                                 {SubmapId("other"), Transform<Submap, Anchor>(random.Rigid())}},
                 .place = {},
                 .kind = "note",
                 .payload = "hello"}};
  ExpectSameBytes(AnchorState{RunId{2}, anchor}, waymark_AnchorState_desc);
  CommandReply reply{.device = kDevice, .anchor = kAnchor};
  ExpectSameBytes(reply, waymark_CommandReply_desc);
  reply.current = anchor;
  ExpectSameBytes(reply, waymark_CommandReply_desc);
  MapState state{.room = RoomId("square"), .epoch = 3};
  state.placements.emplace(SubmapId("a"), Similarity<Map, Submap>(random.Similarity()));
  state.placements.emplace(SubmapId("bcd"), Similarity<Map, Submap>(random.Similarity()));
  ExpectSameBytes(state, waymark_MapState_desc);
}

TEST(Cdr, AnAppendableTypeMayBeLongerOrShorter) {
  Scratch scratch;
  const waymark_Hello hello = Encode(MakeHello(), scratch);
  Bytes bytes = WriteOurs(hello);
  const auto set_size = [&] {
    const auto size = static_cast<std::uint32_t>(bytes.size() - 4);
    std::memcpy(bytes.data(), &size, sizeof(size));
  };
  bytes.insert(bytes.end(), {1, 2, 3, 4, 5, 6, 7, 8});  // members of a later version
  set_size();
  waymark_Hello later{};
  CdrReader reader(bytes, scratch);
  reader(later);
  EXPECT_TRUE(reader.IsComplete());
  EXPECT_STREQ(later.name, hello.name);

  bytes.resize(4 + 16 + 4 + 4);  // a version that knew no room
  set_size();
  waymark_Hello earlier{};
  CdrReader short_reader(bytes, scratch);
  short_reader(earlier);
  EXPECT_TRUE(short_reader.IsComplete());
  EXPECT_EQ(earlier.attempt, hello.attempt);
  EXPECT_STREQ(earlier.room, "");
}

TEST(Cdr, NoSequenceIsLongerThanItsBytesOrItsBound) {
  for (const std::uint32_t count : {9u, 1000u, 0xffffffffu}) {
    Bytes bytes;
    CdrWriter writer(bytes);
    writer(std::uint32_t{5 * 4 + 8 * 16}, std::uint8_t{1}, std::uint32_t{640}, std::uint32_t{480},
           count);
    for (int i = 0; i < 16; ++i) writer(1.0);
    Scratch scratch;
    waymark_CameraIntrinsics camera{};
    CdrReader reader(bytes, scratch);
    reader(camera);
    EXPECT_FALSE(reader.IsComplete()) << count;
  }
}

}  // namespace
}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
// Messages survive the generated types.
#include "tests/session/wire_fixture.h"

namespace waymark::session::wire {
namespace {

using waymark::support::Near;
using waymark::support::RandomGeometry;

RoomAnchor MakeAnchor(RandomGeometry& random) {
  return {.record = {.id = kAnchor,
                     .room = RoomId(""),
                     .owner = kDevice.text(),
                     .map_from_anchor = Transform<Map, Anchor>(random.Rigid()),
                     .epoch = 3,
                     .attachments = {{kSubmap, Transform<Submap, Anchor>(random.Rigid())}},
                     .place = {},
                     .kind = "note",
                     .payload = std::string("\0\xff", 2),
                     .revision = 17},
          .is_supported = false};
}

TEST(Wire, JoiningComesBack) {
  const auto hello = Return(MakeHello());
  ASSERT_TRUE(hello.ok());
  EXPECT_EQ(hello->device, kDevice);
  EXPECT_EQ(hello->protocol, kProtocol);
  EXPECT_EQ(hello->attempt, 9u);
  EXPECT_EQ(hello->room, RoomId("square"));
  EXPECT_EQ(hello->name, "Ännä");

  const auto welcome =
      Return(Welcome{.device = kDevice,
                     .attempt = 9,
                     .verdict = JoinVerdict::kRefused,
                     .reason = "full",
                     .run = RunId{1},
                     .ticket = Ticket{2},
                     .number = DeviceNumber{3},
                     .map = {.map = "m",
                             .is_geo_aligned = false,
                             .origin = {Angle::Degrees(-33), Angle::Degrees(151), 9},
                             .epoch = 4},
                     .session_time = FromNanoseconds<ServerTime>(5)});
  ASSERT_TRUE(welcome.ok());
  EXPECT_EQ(welcome->verdict, JoinVerdict::kRefused);
  EXPECT_EQ(welcome->reason, "full");
  EXPECT_EQ(welcome->ticket, Ticket{2});
  EXPECT_EQ(welcome->map.map, "m");
  EXPECT_FALSE(welcome->map.is_geo_aligned);
  EXPECT_NEAR(welcome->map.origin.longitude.degrees(), 151, 1e-12);
  EXPECT_EQ(ToNanoseconds(welcome->session_time), 5);
}

TEST(Wire, LocalisationComesBack) {
  const auto query = Return(MakeQuery());
  ASSERT_TRUE(query.ok());
  EXPECT_EQ(query->camera, MakeQuery().camera);
  EXPECT_EQ(query->image, MakeQuery().image);
  EXPECT_EQ(query->up_in_camera, MakeQuery().up_in_camera);
  EXPECT_NEAR(query->prior->position.latitude.degrees(), 52, 1e-12);
  EXPECT_EQ(query->time, MakeQuery().time);
  EXPECT_THAT(query->vo_from_camera->rigid(), Near(MakeQuery().vo_from_camera->rigid()));
  ASSERT_THAT(query->earlier, testing::SizeIs(2));
  EXPECT_EQ(query->earlier[1].request, RequestNumber{4});
  EXPECT_THAT(query->earlier[1].vo_from_camera.rigid(),
              Near(MakeQuery().earlier[1].vo_from_camera.rigid()));

  LocaliseQuery bare = MakeQuery();
  bare.prior.reset();
  bare.up_in_camera.reset();
  bare.vo_from_camera.reset();
  bare.earlier.clear();
  const auto bare_returned = Return(bare);
  ASSERT_TRUE(bare_returned.ok());
  EXPECT_FALSE(bare_returned->prior || bare_returned->up_in_camera);
  EXPECT_FALSE(bare_returned->vo_from_camera);
  EXPECT_THAT(bare_returned->earlier, testing::IsEmpty());

  RandomGeometry random(4);
  LocaliseAnswer answer{
      .device = kDevice,
      .request = RequestNumber{5},
      .status = LocaliseStatus::kLocalised,
      .reason = "",
      .epoch = 6,
      .pose =
          localiser::LocalisedPose{.map_from_camera = Transform<Map, Camera>(random.Rigid()),
                                   .covariance = Eigen::Matrix<double, 6, 6>::Random(),
                                   .submap = kSubmap,
                                   .submap_from_camera = Transform<Submap, Camera>(random.Rigid()),
                                   .inliers = 30,
                                   .rms_px = 1.5,
                                   .images = 3},
      .queue_ms = 7,
      .times = {.total_ms = 8},
      .received = ServerTime{std::chrono::seconds(9)},
      .sent = ServerTime{std::chrono::seconds(10)}};
  const auto returned = Return(answer);
  ASSERT_TRUE(returned.ok());
  EXPECT_THAT(returned->pose->map_from_camera.rigid(), Near(answer.pose->map_from_camera.rigid()));
  EXPECT_EQ(returned->pose->covariance, answer.pose->covariance);
  EXPECT_EQ(returned->pose->submap, kSubmap);
  EXPECT_EQ(returned->pose->inliers, 30);
  EXPECT_EQ(returned->pose->images, 3);
  EXPECT_EQ(returned->times.total_ms, 8);
  EXPECT_EQ(returned->received, answer.received);
  EXPECT_EQ(returned->sent, answer.sent);
  answer.status = LocaliseStatus::kBusy;
  EXPECT_THAT(Return(answer), IsRefused());
}

TEST(Wire, AQueryOfAClientThatKnowsNoBurstsIsUnderstood) {
  LocaliseQuery query = MakeQuery();
  query.vo_from_camera.reset();
  query.earlier.clear();
  query.image.assign(8, 1);
  std::vector<std::uint8_t> frame = EncodeFrame(Upward(query));
  frame.resize(frame.size() - 12);  // no odometry, and a sequence of none: as it was before
  const auto size = static_cast<std::uint32_t>(frame.size() - 8);  // head, and the size itself
  std::memcpy(frame.data() + 4, &size, sizeof(size));
  const auto understood = DecodeUpward(frame);
  ASSERT_TRUE(understood.ok()) << ToString(understood.error());
  const auto& earlier = std::get<LocaliseQuery>(*understood);
  EXPECT_EQ(earlier.image, query.image);
  EXPECT_FALSE(earlier.vo_from_camera);
  EXPECT_THAT(earlier.earlier, testing::IsEmpty());
}

TEST(Wire, AreasComeBack) {
  const AreaReport report{
      .ticket = Ticket{7}, .number = 3, .area = {{1.5, -2}, 90}, .is_anew = true};
  const auto asked = Return(report);
  ASSERT_TRUE(asked.ok());
  EXPECT_EQ(asked->ticket, report.ticket);
  EXPECT_EQ(asked->number, 3u);
  EXPECT_EQ(asked->area.centre_m, report.area.centre_m);
  EXPECT_EQ(asked->area.radius_m, 90);
  EXPECT_TRUE(asked->is_anew);
  AreaReport hostile = report;
  hostile.area.centre_m.x() = NAN;
  EXPECT_THAT(Return(hostile), IsRefused());
  hostile = report;
  hostile.area.radius_m = kMaxAreaRadius_m + 1;
  EXPECT_THAT(Return(hostile), IsRefused());

  const AreaState state{.device = kDevice,
                        .run = RunId{2},
                        .number = 4,
                        .area = {{1, 2}, 3},
                        .anchor_count = 5,
                        .anchor_digest = 6};
  const auto told = Return(state);
  ASSERT_TRUE(told.ok());
  EXPECT_EQ(told->device, kDevice);
  EXPECT_EQ(told->run, RunId{2});
  EXPECT_EQ(told->number, 4u);
  EXPECT_EQ(told->area.centre_m, state.area.centre_m);
  EXPECT_EQ(told->anchor_count, 5u);
  EXPECT_EQ(told->anchor_digest, 6u);
}

TEST(Wire, AnchorsComeBack) {
  RandomGeometry random(5);
  const AnchorCommand command = MakeCommand(random);
  const auto returned = Return(command);
  ASSERT_TRUE(returned.ok());
  EXPECT_EQ(returned->request, command.request);
  EXPECT_EQ(returned->operation, AnchorOperation::kMove);
  EXPECT_EQ(returned->anchor, kAnchor);
  EXPECT_EQ(returned->expected_revision, 12u);
  EXPECT_THAT(returned->map_from_anchor.rigid(), Near(command.map_from_anchor.rigid()));
  EXPECT_THAT(returned->seen_in, testing::ElementsAre(kSubmap));
  EXPECT_EQ(returned->payload, command.payload);

  const RoomAnchor anchor = MakeAnchor(random);
  const auto state = Return(AnchorState{RunId{2}, anchor});
  ASSERT_TRUE(state.ok());
  EXPECT_EQ(state->run, RunId{2});
  EXPECT_EQ(state->anchor.record.id, kAnchor);
  EXPECT_EQ(state->anchor.record.revision, 17u);
  EXPECT_EQ(state->anchor.record.payload, anchor.record.payload);
  EXPECT_FALSE(state->anchor.is_supported);
  EXPECT_THAT(state->anchor.record.attachments[0].submap_from_anchor.rigid(),
              Near(anchor.record.attachments[0].submap_from_anchor.rigid()));

  const auto reply = Return(CommandReply{.device = kDevice,
                                         .request = UuidFromBits(3, 4),
                                         .outcome = CommandOutcome::kConflict,
                                         .reason = std::string(500, 'x'),
                                         .anchor = kAnchor,
                                         .current = anchor});
  ASSERT_TRUE(reply.ok());
  EXPECT_EQ(reply->outcome, CommandOutcome::kConflict);
  EXPECT_EQ(reply->reason.size(), kMaxReasonBytes) << "long reasons are cut";
  EXPECT_EQ(reply->current->record.id, kAnchor);

  const auto room = Return(RoomState{.room = RoomId("square"),
                                     .run = RunId{1},
                                     .revision = 2,
                                     .epoch = 3,
                                     .anchor_count = 4,
                                     .anchor_digest = 5});
  ASSERT_TRUE(room.ok());
  EXPECT_EQ(room->anchor_digest, 5u);
}

TEST(Wire, MapStatesKeepEveryPlacementExactly) {
  support::RandomGeometry random(11);
  MapState state{.room = RoomId("square"), .run = RunId{1}, .swap = 2, .epoch = 3};
  for (int i = 0; i < 300; ++i) {
    state.placements.emplace(
        SubmapId(fmt::format("submap{:03}", i)),
        Similarity<Map, Submap>(Sim3(1 + 0.001 * i, random.Rotation(), Eigen::Vector3d(i, 2, 3))));
  }
  const auto returned = Return(state);
  ASSERT_TRUE(returned.ok()) << ToString(returned.error());
  EXPECT_EQ(returned->epoch, 3u);
  EXPECT_EQ(returned->swap, 2u);
  ASSERT_EQ(returned->placements.size(), kMaxPlacements);
  for (const auto& [submap, placed] : returned->placements) {
    const Sim3& sent = state.placements.at(submap).sim();
    EXPECT_EQ(placed.sim().scale(), sent.scale());
    EXPECT_EQ(placed.sim().translation(), sent.translation());
    EXPECT_LT(AngleBetween(placed.sim().rotation(), sent.rotation()).radians(), 1e-12);
  }
  state.placements.clear();
  state.placements.emplace(
      SubmapId("flat"),
      Similarity<Map, Submap>(Sim3(0, Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero())));
  EXPECT_FALSE(Return(state).ok()) << "a submap without size";
}

TEST(Wire, LongTextIsCutBetweenCharacters) {
  Hello hello = MakeHello();
  hello.name = std::string(63, 'x') + "ä";  // 65 bytes
  const auto returned = Return(hello);
  ASSERT_TRUE(returned.ok());
  EXPECT_EQ(returned->name, std::string(63, 'x'));
}

}  // namespace
}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
// Messages survive the generated types, and nothing hostile gets through them.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "session/wire/internal/codec.h"
#include "tests/support/random_geometry.h"

namespace waymark::session::wire {
namespace {

using waymark::support::Near;
using waymark::support::RandomGeometry;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

const DeviceId kDevice{"01234567-89ab-4def-bedc-ba9876543210"};
const AnchorId kAnchor{"11234567-89ab-4def-bedc-ba9876543210"};
const SubmapId kSubmap{"00112233445566778899aabbccddeeff"};

/// Through the generated type and back.
template <typename Message>
Result<Message> Return(const Message& message) {
  Scratch scratch;
  return Decode(Encode(message, scratch));
}

/// The error of decoding after somebody changed the encoded message.
template <typename Message, typename Change>
Result<Message> ReturnChanged(const Message& message, const Change& change) {
  Scratch scratch;
  auto wire = Encode(message, scratch);
  change(wire);
  return Decode(wire);
}

MATCHER(IsRefused, "is refused as invalid") {
  if (arg.ok()) return false;
  *result_listener << ToString(arg.error());
  return arg.error().code == ErrorCode::kInvalidArgument;
}

Hello MakeHello() {
  return {.device = kDevice, .protocol = 3, .attempt = 9, .room = RoomId("square"), .name = "Ännä"};
}

LocaliseQuery MakeQuery() {
  const std::array<double, 4> parameters{500, 510, 320, 240};
  return {.ticket = Ticket{77},
          .request = RequestNumber{5},
          .time = FromNanoseconds<DeviceTime>(123456789),
          .camera = *CameraModel::Create(CameraKind::kPinhole, 640, 480, parameters),
          .prior = GeoPrior{.position = {Angle::Degrees(52), Angle::Degrees(13), 34}, .sigma_m = 4},
          .up_in_camera = Eigen::Vector3d(0, -1, 0),
          .image = {1, 2, 3}};
}

AnchorCommand MakeCommand(RandomGeometry& random) {
  return {.ticket = Ticket{77},
          .request = UuidFromBits(1, 2),
          .operation = AnchorOperation::kMove,
          .anchor = kAnchor,
          .expected_revision = 12,
          .epoch = 3,
          .map_from_anchor = Transform<Map, Anchor>(random.Rigid()),
          .seen_in = {kSubmap},
          .kind = "note",
          .payload = std::string("\0\x01 bytes", 8)};
}

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
  EXPECT_EQ(hello->protocol, 3u);
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

TEST(Wire, PosesComeBackToFloatPrecision) {
  RandomGeometry random(3);
  PoseBatch batch{.chunk = 1, .tick = 2, .run = RunId{3}, .poses = {}};
  for (std::uint32_t i = 0; i < kMaxPosesPerBatch; ++i) {
    batch.poses.push_back({DeviceNumber{i},
                           {.epoch = 4,
                            .time = FromNanoseconds<ServerTime>(i),
                            .map_from_device = Transform<Map, Device>(random.Rigid()),
                            .sigma_m = 0.5}});
  }
  const auto returned = Return(batch);
  ASSERT_TRUE(returned.ok());
  ASSERT_EQ(returned->poses.size(), batch.poses.size());
  for (std::size_t i = 0; i < batch.poses.size(); ++i) {
    EXPECT_EQ(returned->poses[i].number, batch.poses[i].number);
    EXPECT_EQ(returned->poses[i].pose.time, batch.poses[i].pose.time);
    EXPECT_LT(Difference(returned->poses[i].pose.map_from_device.rigid(),
                         batch.poses[i].pose.map_from_device.rigid())
                  .norm(),
              1e-5);
  }
  const auto report = Return(PoseReport{Ticket{8}, batch.poses[3].pose});
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->ticket, Ticket{8});
  EXPECT_EQ(report->pose.epoch, 4u);
}

TEST(Wire, ABatchFitsOneFragment) {
  // Measured: best effort of several fragments is lost as (1 - p)^n; a fragment holds 1344 octets.
  EXPECT_EQ(sizeof(waymark_SharedPose), 48u);
  EXPECT_LE(kMaxPosesPerBatch * sizeof(waymark_SharedPose) + 32, 1344u);
}

TEST(Wire, LocalisationComesBack) {
  const auto query = Return(MakeQuery());
  ASSERT_TRUE(query.ok());
  EXPECT_EQ(query->camera, MakeQuery().camera);
  EXPECT_EQ(query->image, MakeQuery().image);
  EXPECT_EQ(query->up_in_camera, MakeQuery().up_in_camera);
  EXPECT_NEAR(query->prior->position.latitude.degrees(), 52, 1e-12);
  EXPECT_EQ(query->time, MakeQuery().time);

  LocaliseQuery bare = MakeQuery();
  bare.prior.reset();
  bare.up_in_camera.reset();
  const auto bare_returned = Return(bare);
  ASSERT_TRUE(bare_returned.ok());
  EXPECT_FALSE(bare_returned->prior || bare_returned->up_in_camera);

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
                                   .rms_px = 1.5},
      .queue_ms = 7,
      .times = {.total_ms = 8}};
  const auto returned = Return(answer);
  ASSERT_TRUE(returned.ok());
  EXPECT_THAT(returned->pose->map_from_camera.rigid(), Near(answer.pose->map_from_camera.rigid()));
  EXPECT_EQ(returned->pose->covariance, answer.pose->covariance);
  EXPECT_EQ(returned->pose->submap, kSubmap);
  EXPECT_EQ(returned->pose->inliers, 30);
  EXPECT_EQ(returned->times.total_ms, 8);
  answer.status = LocaliseStatus::kBusy;
  EXPECT_THAT(Return(answer), IsRefused());
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

TEST(Wire, LongTextIsCutBetweenCharacters) {
  Hello hello = MakeHello();
  hello.name = std::string(63, 'x') + "ä";  // 65 bytes
  const auto returned = Return(hello);
  ASSERT_TRUE(returned.ok());
  EXPECT_EQ(returned->name, std::string(63, 'x'));
}

TEST(Wire, HostileNamesAreRefused) {
  for (const std::string room : {"", "a b", "a.b", "*", "../x", "room\n", "ä", "%s%n"}) {
    Hello hello = MakeHello();
    hello.room = RoomId(room);
    EXPECT_THAT(Return(hello), IsRefused()) << room;
  }
  for (const std::string name :
       {"\x01", "\n", "\x7f", "\xff", "\xc0\xaf", "\xed\xa0\x80", "\xe2\x82", "\xf4\x90\x80\x80"}) {
    Hello hello = MakeHello();
    hello.name = name;
    EXPECT_THAT(Return(hello), IsRefused()) << name;
  }
}

TEST(Wire, HostilePosesAreRefused) {
  RandomGeometry random(6);
  const PoseReport report{Ticket{1},
                          {.time = {}, .map_from_device = Transform<Map, Device>(random.Rigid())}};
  for (const float bad : {NAN, INFINITY, -INFINITY, 2e6f}) {
    EXPECT_THAT(ReturnChanged(report, [&](auto& wire) { wire.map_position_m[1] = bad; }),
                IsRefused());
    EXPECT_THAT(ReturnChanged(report, [&](auto& wire) { wire.map_quaternion_xyzw[2] = bad; }),
                IsRefused());
  }
  EXPECT_THAT(ReturnChanged(report,
                            [](auto& wire) {
                              std::fill(std::begin(wire.map_quaternion_xyzw),
                                        std::end(wire.map_quaternion_xyzw), 0.f);
                            }),
              IsRefused());
  for (const float bad : {NAN, -1.f, INFINITY}) {
    EXPECT_THAT(ReturnChanged(report, [&](auto& wire) { wire.sigma_m = bad; }), IsRefused());
  }
}

TEST(Wire, HostileQueriesAreRefused) {
  const LocaliseQuery query = MakeQuery();
  const auto refuse = [&](const auto& change) {
    EXPECT_THAT(ReturnChanged(query, change), IsRefused());
  };
  refuse([](auto& wire) { wire.image._length = 0; });
  refuse([](auto& wire) { wire.image._length = kMaxImageBytes + 1; });
  refuse([](auto& wire) { wire.camera.kind = 200; });
  refuse([](auto& wire) { wire.camera.width_px = 0; });
  refuse([](auto& wire) { wire.camera.height_px = 0xffffffff; });
  refuse([](auto& wire) { wire.camera.parameters._length = 3; });
  refuse([](auto& wire) { wire.camera.parameters._buffer = nullptr; });
  for (const double bad : {kNan, kInfinity, 91.0}) {
    refuse([&](auto& wire) { wire.prior->position.latitude_deg = bad; });
  }
  for (const double bad : {kNan, kInfinity, -1.0}) {
    refuse([&](auto& wire) { wire.prior->sigma_m = bad; });
  }
  for (const double bad : {kNan, 0.0, 5.0, kInfinity}) {
    refuse([&](auto& wire) { wire.up_in_camera->y = bad; });
  }
}

TEST(Wire, HostileCommandsAreRefused) {
  RandomGeometry random(7);
  const AnchorCommand command = MakeCommand(random);
  const auto refuse = [&](const auto& change) {
    EXPECT_THAT(ReturnChanged(command, change), IsRefused());
  };
  refuse([](auto& wire) { wire.payload._length = kMaxPayloadBytes + 1; });
  refuse([](auto& wire) { wire.seen_in._length = 4; });
  refuse([](auto& wire) { wire.seen_in._buffer[0].submap[0] = '/'; });
  refuse([](auto& wire) { wire.kind[0] = '\x02'; });
  refuse([](auto& wire) { wire.operation = static_cast<waymark_AnchorOperation>(3); });
  for (const double bad : {kNan, kInfinity, 1e7}) {
    refuse([&](auto& wire) { wire.map_from_anchor.position_m[0] = bad; });
    refuse([&](auto& wire) { wire.map_from_anchor.quaternion_xyzw[0] = bad; });
  }
}

}  // namespace
}  // namespace waymark::session::wire

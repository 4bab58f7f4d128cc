// SPDX-License-Identifier: Apache-2.0
// How exactly poses travel: the bounds that idl/README.md states.
#include <numbers>

#include "session/wire/internal/shared_pose.h"
#include "session/wire/pose_sheet.h"
#include "tests/session/wire_fixture.h"

namespace waymark::session::wire {
namespace {

using support::RandomGeometry;

constexpr ServerTime kNow = FromNanoseconds<ServerTime>(1'000'000'000'000);

SharedPose MakePose(RandomGeometry& random, const Eigen::Vector3d& position) {
  return {DeviceNumber{77},
          {.epoch = 4,
           .time = kNow - std::chrono::milliseconds(41),
           .map_from_device = Transform<Map, Device>(random.Rigid().rotation(), position),
           .sigma_m = 0.05,
           .rotation_sigma_rad = 0.01,
           .tracking = localiser::AlignmentState::kFixed}};
}

SharedPose Through(const SharedPose& shared, const PoseReference& reference) {
  const auto returned = DecodeSharedPose(EncodeSharedPose(shared, reference), reference, 4);
  EXPECT_TRUE(returned.ok()) << ToString(returned.error());
  return returned.ok() ? *returned : SharedPose{};
}

TEST(SharedPose, ComesBackWithinItsBounds) {
  RandomGeometry random(3);
  const PoseReference reference{.time = kNow, .origin_m = {1024, -2048, 0}};
  for (int i = 0; i < 10'000; ++i) {
    const Eigen::Vector3d offset = random.Vector(1).cwiseProduct(Eigen::Vector3d(8388, 8388, 262));
    const SharedPose sent = MakePose(random, offset + Eigen::Vector3d(1024, -2048, 0));
    const SharedPose found = Through(sent, reference);
    const Rigid3 before = sent.pose.map_from_device.rigid(),
                 after = found.pose.map_from_device.rigid();
    ASSERT_LE((after.translation() - before.translation()).cwiseAbs().maxCoeff(), 0.001 + 1e-9);
    ASSERT_LE(AngleBetween(after.rotation(), before.rotation()).radians(), 0.00015);
    EXPECT_EQ(found.number, sent.number);
    EXPECT_EQ(found.pose.tracking, sent.pose.tracking);
    EXPECT_EQ(found.pose.epoch, 4u);
    EXPECT_EQ(found.pose.time, sent.pose.time);
  }
}

TEST(SharedPose, FarFromItsOriginIsCoarser) {
  RandomGeometry random(4);
  const PoseReference reference{.time = kNow};
  for (const Eigen::Vector3d& position :
       {Eigen::Vector3d(9'000, 3, 4), Eigen::Vector3d(0, -500'000, 0),
        Eigen::Vector3d(5, 5, 300)}) {
    const SharedPose found = Through(MakePose(random, position), reference);
    EXPECT_LE((found.pose.map_from_device.translation() - position).cwiseAbs().maxCoeff(), 0.0641);
  }
}

TEST(SharedPose, RotationsAtTheEdgesComeBack) {
  const PoseReference reference{.time = kNow};
  const double half = std::sqrt(0.5);
  for (const Eigen::Vector4d& xyzw :
       {Eigen::Vector4d(1, 0, 0, 0), Eigen::Vector4d(0, 0, 0, -1),
        Eigen::Vector4d(half, half, 0, 0), Eigen::Vector4d(0, -half, 0, half),
        Eigen::Vector4d(.5, -.5, .5, -.5), Eigen::Vector4d(-.5, -.5, -.5, -.5)}) {
    SharedPose sent;
    sent.pose.time = kNow;
    sent.pose.map_from_device = {Eigen::Quaterniond(xyzw), Eigen::Vector3d::Zero()};
    const SharedPose found = Through(sent, reference);
    EXPECT_LE(
        AngleBetween(found.pose.map_from_device.rotation(), Eigen::Quaterniond(xyzw)).radians(),
        0.00015)
        << xyzw.transpose();
  }
}

TEST(SharedPose, AgeSigmaAndVelocityComeBackWithinTheirs) {
  RandomGeometry random(5);
  const PoseReference reference{.time = kNow};
  for (int i = 0; i < 1000; ++i) {
    SharedPose sent = MakePose(random, {1, 2, 3});
    sent.pose.time = kNow - std::chrono::microseconds(i * 16'000) + std::chrono::seconds(1);
    sent.pose.sigma_m = 1e-3 * std::pow(10, 6 * i / 1000.0);
    sent.pose.velocity_in_map = random.Vector(kMaxSpeed_mps);
    const LivePose found = Through(sent, reference).pose;
    EXPECT_LE(std::abs((found.time - sent.pose.time).count()), 250'000);
    EXPECT_NEAR(found.sigma_m / sent.pose.sigma_m, 1, 0.03);
    for (int axis = 0; axis < 3; ++axis) {
      const double speed = std::abs(sent.pose.velocity_in_map[axis]);
      EXPECT_NEAR(found.velocity_in_map[axis], sent.pose.velocity_in_map[axis],
                  std::sqrt(speed * kMaxSpeed_mps) / 127 + 0.002);
    }
  }
}

TEST(SharedPose, HowWellItKnowsWhereItIsComesBackBesideTheLargestNumber) {
  RandomGeometry random(8);
  const PoseReference reference{.time = kNow};
  for (int i = 0; i < 1000; ++i) {
    SharedPose sent = MakePose(random, {1, 2, 3});
    sent.number = DeviceNumber{kDeviceNumbers - 1};
    sent.pose.rotation_sigma_rad = 1e-3 * std::pow(10, 3 * i / 1000.0);
    sent.pose.tracking = static_cast<localiser::AlignmentState>(i % 4);
    const SharedPose found = Through(sent, reference);
    EXPECT_EQ(found.number, sent.number);
    EXPECT_EQ(found.pose.tracking, sent.pose.tracking);
    EXPECT_NEAR(found.pose.rotation_sigma_rad / sent.pose.rotation_sigma_rad, 1, 0.06);
  }
}

TEST(SharedPose, WhatIsBeyondIsCut) {
  RandomGeometry random(6);
  const PoseReference reference{.time = kNow};
  SharedPose sent = MakePose(random, {1, 2, 3});
  sent.pose.time = kNow - std::chrono::hours(1);
  sent.pose.sigma_m = 1e9;
  sent.pose.rotation_sigma_rad = 1e9;
  sent.pose.velocity_in_map = {1e4, 0, -1e4};
  const LivePose found = Through(sent, reference).pose;
  EXPECT_NEAR(Seconds(kNow - found.time), 16.4, 0.1);
  EXPECT_NEAR(found.sigma_m, 1000, 1);
  EXPECT_NEAR(found.rotation_sigma_rad, 1, 1e-6);
  EXPECT_EQ(found.velocity_in_map, Eigen::Vector3d(kMaxSpeed_mps, 0, -kMaxSpeed_mps));
}

TEST(SharedPose, HostileOctetsAreRefusedOrFinite) {
  RandomGeometry random(7);
  const PoseReference reference{.time = kNow, .origin_m = {2'000'000'000, 0, 0}};
  EXPECT_THAT(DecodeSharedPose({}, reference, 1), IsRefused()) << "beyond the map";
  waymark_SharedPose wire{};
  for (auto& part : wire.rotation) part = 0xffff;
  EXPECT_THAT(DecodeSharedPose(wire, {.time = kNow}, 1), IsRefused()) << "no rotation";
}

TEST(PoseBatchFrame, ABatchFitsOneFragment) {
  // Measured: best effort of several fragments is lost as (1 - p)^n; a fragment holds 1344 octets.
  PoseBatch batch;
  batch.poses.resize(kMaxPosesPerBatch);
  EXPECT_EQ(sizeof(waymark_SharedPose), 24u);
  EXPECT_LE(EncodeFrame(Downward(batch)).size(), 1344u);
}

TEST(PoseBatchFrame, ComesBack) {
  RandomGeometry random(8);
  PoseBatch batch{
      .chunk = 1, .chunks = 3, .tick = 2, .epoch = 4, .run = RunId{3}, .time = kNow, .poses = {}};
  for (std::size_t i = 0; i < kMaxPosesPerBatch; ++i) {
    batch.poses.push_back(MakePose(random, 100 * random.Vector(1)));
  }
  const auto returned = Return(batch);
  ASSERT_TRUE(returned.ok()) << ToString(returned.error());
  EXPECT_EQ(returned->chunks, 3u);
  EXPECT_EQ(returned->epoch, 4u);
  EXPECT_EQ(returned->time, kNow);
  ASSERT_EQ(returned->poses.size(), batch.poses.size());
  const auto report = Return(PoseReport{Ticket{8}, batch.poses[3].pose});
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->ticket, Ticket{8});
  EXPECT_LT(
      Difference(report->pose.map_from_device.rigid(), batch.poses[3].pose.map_from_device.rigid())
          .norm(),
      1e-5);
}

TEST(PoseSheet, MakesTheFramesThatEncodingMakes) {
  RandomGeometry random(9);
  PoseBatch batch{.tick = 5, .epoch = 4, .run = RunId{3}, .time = kNow, .poses = {}};
  std::vector<SharedPose> poses;
  for (std::uint32_t i = 0; i < 200; ++i) {
    poses.push_back(MakePose(random, 100 * random.Vector(1)));
    poses.back().number = DeviceNumber{i};
  }
  const PoseSheet sheet(batch, poses);
  for (const std::vector<std::uint32_t>& chosen :
       {std::vector<std::uint32_t>{}, {7}, {199, 0, 3}, {1, 2, 3, 4, 5, 6, 7, 8, 9}}) {
    batch.poses.clear();
    for (const std::uint32_t i : chosen) batch.poses.push_back(poses[i]);
    EXPECT_EQ(*sheet.Frame(chosen), EncodeFrame(Downward(batch)));
  }
}

TEST(GatewayBundles, ComeBackOnTheBus) {
  RandomGeometry random(10);
  GatewayReport report{.gateway = GatewayId{5}, .poses = {}, .pings = {}};
  for (std::size_t i = 0; i < kMaxPerGatewayReport; ++i) {
    report.poses.push_back({Ticket{i}, MakePose(random, {1, 2, 3}).pose});
  }
  report.pings.push_back({Ticket{9}, 4, FromNanoseconds<DeviceTime>(7)});
  Scratch scratch;
  waymark_GatewayReport wire = Encode(report, scratch);
  wire.poses._buffer[3].map_position_m[0] = NAN;
  const auto returned = Decode(wire);
  ASSERT_TRUE(returned.ok());
  EXPECT_EQ(returned->gateway, GatewayId{5});
  EXPECT_EQ(returned->poses.size(), kMaxPerGatewayReport - 1) << "but for the one that is none";
  ASSERT_EQ(returned->pings.size(), 1u);
  EXPECT_EQ(returned->pings[0].sequence_number, 4u);
  const auto pongs = Decode(Encode(
      GatewayPongs{.gateway = GatewayId{5}, .pongs = {ClockPong{.device = kDevice}}}, scratch));
  ASSERT_TRUE(pongs.ok());
  EXPECT_EQ(pongs->pongs.at(0).device, kDevice);
}

}  // namespace
}  // namespace waymark::session::wire

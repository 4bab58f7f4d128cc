// SPDX-License-Identifier: Apache-2.0
// The parts of a device session that need no network: clock, room view, desks, pose.
#include <gmock/gmock.h>

#include "session/device/clock_estimator.h"
#include "session/device/internal/desks.h"
#include "session/device/jpeg.h"
#include "session/device/pose_tracker.h"
#include "session/device/room_view.h"
#include "tests/support/random_geometry.h"

namespace waymark::session {
namespace {

using internal::CommandDesk;
using internal::ImageDesk;
using internal::Instant;
using internal::JoinDesk;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

// ---- clock ------------------------------------------------------------------------------------

ClockExchange Exchange(nanoseconds offset, nanoseconds up, nanoseconds down) {
  const DeviceTime sent{seconds(100)};
  const ServerTime received{sent.time_since_epoch() + offset + up};
  const ServerTime replied = received + milliseconds(1);
  return {sent, received, replied, DeviceTime{replied.time_since_epoch() - offset + down}};
}

TEST(ClockEstimator, TakesTheExchangeWithTheLeastDelay) {
  constexpr nanoseconds kOffset = seconds(-12345);
  ClockEstimator clock;
  EXPECT_FALSE(clock.ToSession(DeviceTime{}));
  clock.Add(Exchange(kOffset, milliseconds(90), milliseconds(10)));
  EXPECT_EQ(*clock.ToSession(DeviceTime{}), ServerTime{kOffset + milliseconds(40)});
  clock.Add(Exchange(kOffset, milliseconds(5), milliseconds(5)));
  clock.Add(Exchange(kOffset, milliseconds(5), milliseconds(500)));
  EXPECT_EQ(*clock.ToSession(DeviceTime{}), ServerTime{kOffset});
  EXPECT_EQ(*clock.Delay(), milliseconds(10));
}

TEST(ClockEstimator, ForgetsWhatIsOldAndIgnoresTheImpossible) {
  ClockEstimator clock;
  clock.Add(Exchange(seconds(1), milliseconds(1), milliseconds(1)));
  for (int i = 0; i < 32; ++i) clock.Add(Exchange(seconds(2), milliseconds(9), milliseconds(9)));
  EXPECT_EQ(*clock.ToSession(DeviceTime{}), ServerTime{seconds(2)}) << "clocks drift";
  clock.Add(Exchange(seconds(3), milliseconds(-5), milliseconds(1)));
  EXPECT_EQ(*clock.ToSession(DeviceTime{}), ServerTime{seconds(2)});
}

TEST(StampClock, TakesTheLeastDelayAndFollowsJumps) {
  StampClock clock;
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(3)}), DeviceTime{seconds(3)});
  clock.Observe(DeviceTime{seconds(3)}, DeviceTime{seconds(100) + milliseconds(80)});
  clock.Observe(DeviceTime{seconds(4)}, DeviceTime{seconds(101) + milliseconds(5)});
  clock.Observe(DeviceTime{seconds(5)}, DeviceTime{seconds(102) + milliseconds(50)});
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(6)}), DeviceTime{seconds(103) + milliseconds(5)});
  clock.Observe(DeviceTime{seconds(6)}, DeviceTime{seconds(110)});
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(6)}), DeviceTime{seconds(110)}) << "it was paused";
  clock.Observe(DeviceTime{seconds(500)}, DeviceTime{seconds(111)});
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(500)}), DeviceTime{seconds(111)}) << "it was set";
}

// ---- room view --------------------------------------------------------------------------------

constexpr RunId kRun{1}, kNextRun{2};
const ServerTime kNow{seconds(1000)};

AnchorId AnchorNamed(int number) {
  return AnchorId(FormatUuid(UuidFromBits(1, static_cast<std::uint64_t>(number))));
}
AnchorState State(int number, std::uint64_t revision, RunId run = kRun) {
  AnchorState state{run, {.record = {.id = AnchorNamed(number), .room = RoomId("")}}};
  state.anchor.record.revision = revision;
  return state;
}
RoomState RoomOf(std::initializer_list<std::pair<int, std::uint64_t>> anchors, RunId run = kRun) {
  RoomState room{.room = RoomId("square"), .run = run};
  for (const auto& [number, revision] : anchors) {
    ++room.anchor_count;
    room.anchor_digest ^= AnchorDigest(AnchorNamed(number), revision);
  }
  return room;
}

class View : public testing::Test {
 protected:
  View() { view_.StartRun(kRun); }

  std::vector<std::string> Ids() const {
    std::vector<std::string> ids;
    for (const SharedAnchor& anchor : view_.Anchors()) ids.push_back(anchor.id.text());
    return ids;
  }

  const DeviceId self_{"self"}, ben_{"ben"};
  RoomView view_{self_};
};

TEST_F(View, IsCompleteWhenCountAndDigestAgreeInAnyOrder) {
  EXPECT_FALSE(view_.HasSnapshot());
  view_.On(State(1, 10));
  view_.On(RoomOf({{1, 10}, {2, 12}}));
  EXPECT_FALSE(view_.HasSnapshot());
  view_.On(State(2, 11));
  EXPECT_FALSE(view_.HasSnapshot()) << "the right count, but an old revision";
  view_.On(State(2, 12));
  EXPECT_TRUE(view_.HasSnapshot());
  view_.On(State(3, 13));
  EXPECT_TRUE(view_.HasSnapshot()) << "from then on changes just arrive";
  EXPECT_THAT(Ids(), SizeIs(3));
}

TEST_F(View, AnEmptyRoomIsComplete) {
  view_.On(RoomOf({}));
  EXPECT_TRUE(view_.HasSnapshot());
}

TEST_F(View, OlderRevisionsDoNotReturn) {
  view_.OnOwnChange(State(1, 12).anchor);
  view_.On(State(1, 10));
  EXPECT_EQ(view_.Anchors()[0].revision, 12u);
  view_.OnGone(AnchorNamed(1));
  view_.OnOwnChange(State(1, 12).anchor);
  EXPECT_THAT(view_.Anchors(), IsEmpty()) << "a late answer does not raise the dead";
}

// run 1   anchors 1 2         server gone, 2 deleted
// run 2                       anchor 1, state {1}: complete, and 2 is dropped
TEST_F(View, ANewRunKeepsTheOldAnchorsUntilItIsComplete) {
  view_.On(State(1, 10));
  view_.On(State(2, 11));
  view_.On(RoomOf({{1, 10}, {2, 11}}));
  ASSERT_TRUE(view_.HasSnapshot());
  view_.On(State(1, 10, kNextRun));  // before its welcome
  view_.StartRun(kNextRun);
  EXPECT_FALSE(view_.HasSnapshot());
  EXPECT_THAT(Ids(), SizeIs(2)) << "content does not flicker";
  view_.On(RoomOf({{1, 10}}, kNextRun));
  EXPECT_TRUE(view_.HasSnapshot());
  EXPECT_THAT(Ids(), ElementsAre(AnchorNamed(1).text()));
}

// The same run, but a silence so long that the deletion of 2 is no longer told.
TEST_F(View, AfterALongSilenceWhatIsNotDeliveredAnewIsOver) {
  view_.On(State(1, 10));
  view_.On(State(2, 11));
  view_.On(RoomOf({{1, 10}, {2, 11}}));
  view_.BeginResync();
  EXPECT_TRUE(view_.HasSnapshot()) << "nothing says otherwise yet";
  view_.On(RoomOf({{1, 10}}));
  view_.On(State(1, 10));
  EXPECT_TRUE(view_.HasSnapshot());
  EXPECT_THAT(Ids(), ElementsAre(AnchorNamed(1).text()));
}

TEST_F(View, OthersComeMoveAndGo) {
  const auto pose = [&](double x, ServerTime time, RunId run = kRun) {
    return PoseBatch{.run = run,
                     .poses = {{DeviceNumber{5},
                                {.time = time,
                                 .map_from_device = {Eigen::Quaterniond::Identity(), {x, 0, 0}}}}}};
  };
  view_.On(Presence{self_, DeviceNumber{4}, "me", kRun});
  view_.On(pose(1, kNow));
  view_.On(Presence{ben_, DeviceNumber{5}, "Ben", kRun});
  ASSERT_THAT(view_.Others(kNow), SizeIs(1)) << "oneself is not another";
  EXPECT_TRUE(view_.Others(kNow)[0].is_present);
  EXPECT_FALSE(view_.Others(kNow)[0].map_from_device) << "the number meant nobody then";
  view_.On(pose(2, kNow));
  view_.On(pose(3, kNow - seconds(1)));
  view_.On(pose(4, kNow + seconds(1), kNextRun));
  const OtherDevice ben = view_.Others(kNow + seconds(2))[0];
  EXPECT_EQ(ben.map_from_device->translation().x(), 2) << "neither late nor of another run";
  EXPECT_EQ(ben.age, seconds(2));
  view_.OnGone(ben_, kNow);
  EXPECT_FALSE(view_.Others(kNow)[0].is_present);
  EXPECT_THAT(view_.Others(kNow + seconds(31)), IsEmpty());
}

// ---- desks ------------------------------------------------------------------------------------

const Instant kStart{seconds(5000)};

Welcome Accepted(std::uint32_t attempt, RunId run = kRun) {
  return {.device = DeviceId("d"),
          .attempt = attempt,
          .verdict = JoinVerdict::kAccepted,
          .reason = "",
          .run = run,
          .ticket = Ticket{static_cast<std::uint64_t>(run)},
          .number = DeviceNumber{1},
          .map = {},
          .session_time = {}};
}

TEST(JoinDesk, RepeatsUntilWelcomedAndIgnoresAnswersToOthers) {
  JoinDesk desk(0xfffffffe);  // attempts may wrap
  EXPECT_TRUE(desk.TakeHelloDue(kStart));
  EXPECT_FALSE(desk.TakeHelloDue(kStart + milliseconds(100)));
  EXPECT_TRUE(desk.TakeHelloDue(kStart + milliseconds(300)));
  EXPECT_EQ(desk.On(Accepted(3), kStart), JoinDesk::Outcome::kIgnored) << "an earlier life's";
  EXPECT_EQ(desk.On(Accepted(0xfffffffe), kStart), JoinDesk::Outcome::kJoined);
  EXPECT_EQ(desk.On(Accepted(0xfffffffe), kStart), JoinDesk::Outcome::kIgnored);
  EXPECT_FALSE(desk.TakeHelloDue(kStart + seconds(1)));
  EXPECT_TRUE(desk.TakePingDue(kStart));
}

TEST(JoinDesk, SilenceMeansJoiningAgain) {
  JoinDesk desk(1);
  desk.TakeHelloDue(kStart);
  desk.On(Accepted(1), kStart);
  ClockPong pong{DeviceId("d"), 0, {}, {}, {}, kRun};
  desk.OnPong(pong, kStart + seconds(1));
  EXPECT_FALSE(desk.TakeHelloDue(kStart + milliseconds(2600)));
  EXPECT_TRUE(desk.TakeHelloDue(kStart + milliseconds(2601)));
  EXPECT_FALSE(desk.IsConnected());
  EXPECT_EQ(desk.attempt(), 2u);
  EXPECT_FALSE(desk.TakeLongSilence(kStart + milliseconds(4900)));
  EXPECT_TRUE(desk.TakeLongSilence(kStart + milliseconds(5000)));
  EXPECT_FALSE(desk.TakeLongSilence(kStart + milliseconds(6000))) << "once per silence";
  EXPECT_EQ(desk.On(Accepted(2, kNextRun), kStart + seconds(6)), JoinDesk::Outcome::kJoined);
  EXPECT_EQ(desk.welcome()->run, kNextRun);
}

DeviceFrame Frame(DeviceTime time) {
  const std::array<double, 3> parameters{1, 1, 1};
  return {.width_px = 2,
          .height_px = 2,
          .pixels = {1, 2, 3, 4},
          .camera = *CameraModel::Create(CameraKind::kSimplePinhole, 2, 2, parameters),
          .device_from_camera = {},
          .vo_from_device = {},
          .time = time};
}

TEST(ImageDesk, OneImageIsUnderWayAtATime) {
  ImageDesk desk(seconds(1), seconds(5));
  const DeviceTime t{seconds(10)};
  RequestNumber first{}, second{};
  EXPECT_FALSE(desk.TakeFrame(first));
  EXPECT_TRUE(desk.Offer(Frame(t), kStart));
  EXPECT_TRUE(desk.TakeFrame(first));
  EXPECT_FALSE(desk.Offer(Frame(t + seconds(2)), kStart)) << "one is under way";
  EXPECT_FALSE(desk.TakeMatch(RequestNumber{99}));
  const auto match = desk.TakeMatch(first);
  ASSERT_TRUE(match);
  EXPECT_EQ(match->frame.time, t);
  EXPECT_EQ(match->pushed, kStart);
  EXPECT_FALSE(desk.TakeMatch(first)) << "answered twice counts once";
  EXPECT_FALSE(desk.Offer(Frame(t + milliseconds(900)), kStart)) << "too early";
  EXPECT_TRUE(desk.Offer(Frame(t + seconds(1)), kStart));
  EXPECT_TRUE(desk.TakeFrame(second));
  EXPECT_NE(first, second);
  EXPECT_FALSE(desk.TakeTimeout(kStart + milliseconds(4999)));
  EXPECT_TRUE(desk.TakeTimeout(kStart + seconds(5)));
  EXPECT_FALSE(desk.TakeMatch(second)) << "too late";
  EXPECT_TRUE(desk.Offer(Frame(t - seconds(5)), kStart)) << "a clock set back is not early";
}

TEST(CommandDesk, RepeatsUntilAnswered) {
  CommandDesk desk;
  const AnchorCommand command{.request = UuidFromBits(1, 1), .anchor = AnchorNamed(1)};
  desk.Add(command, kStart);
  EXPECT_THAT(desk.TakeDue(kStart), SizeIs(1));
  EXPECT_THAT(desk.TakeDue(kStart + milliseconds(299)), IsEmpty());
  EXPECT_THAT(desk.TakeDue(kStart + milliseconds(300)), SizeIs(1));
  CommandReply reply{.device = DeviceId("d"),
                     .request = command.request,
                     .outcome = CommandOutcome::kUnavailable,
                     .reason = "locked",
                     .anchor = command.anchor,
                     .current = std::nullopt};
  EXPECT_TRUE(desk.On(reply));
  EXPECT_EQ(desk.FindReply(command.request), nullptr) << "what may pass is asked again";
  EXPECT_THAT(desk.TakeDue(kStart + seconds(1)), SizeIs(1));
  reply.outcome = CommandOutcome::kApplied;
  EXPECT_TRUE(desk.On(reply));
  EXPECT_NE(desk.FindReply(command.request), nullptr);
  EXPECT_THAT(desk.TakeDue(kStart + seconds(2)), IsEmpty());
  const auto farewell = desk.Remove(command.request);
  EXPECT_EQ(farewell.sent, 3);
  EXPECT_EQ(farewell.last_refusal, "locked");
  EXPECT_FALSE(desk.On(reply)) << "nobody waits any more";
}

// ---- pose -------------------------------------------------------------------------------------

TEST(PoseTracker, CarriesCovarianceAlongTheLever) {
  support::RandomGeometry random(8);
  const Rigid3 b_from_a = random.Rigid(), a_from_c = random.Rigid();
  const Eigen::Vector3d lever_in_b = b_from_a.rotation() * a_from_c.translation();
  // Against differences: column i of the factor is the response to a step in delta i.
  constexpr double kStep = 1e-6;
  Eigen::Matrix<double, 6, 6> response;
  for (int i = 0; i < 6; ++i) {
    Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
    delta(i) = kStep;
    response.col(i) = Difference(b_from_a * a_from_c, Perturb(b_from_a, delta) * a_from_c) / kStep;
  }
  const Eigen::Matrix<double, 6, 6> factor = Eigen::Matrix<double, 6, 6>::Random();
  const Eigen::Matrix<double, 6, 6> covariance = factor * factor.transpose();
  EXPECT_LT((CarryCovariance(covariance, lever_in_b) - response * covariance * response.transpose())
                .norm(),
            1e-3);
}

TEST(PoseTracker, AFixPlacesTheOdometryInTheMap) {
  support::RandomGeometry random(9);
  PoseTracker tracker({}, {});
  const Transform<Map, Vo> map_from_vo(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ())), {4, 5, 6});
  const Transform<Device, Camera> device_from_camera(random.Rigid());
  const Transform<Vo, Device> then(Rigid3(Eigen::Quaterniond::Identity(), {1, 0, 0}));
  const Transform<Vo, Device> now(random.Rigid());
  EXPECT_FALSE(tracker.Pose(1).map_from_device);
  tracker.AddFix({.request = {},
                  .time = DeviceTime{seconds(1)},
                  .device_from_camera = device_from_camera,
                  .vo_from_device = then},
                 {.map_from_camera = map_from_vo * then * device_from_camera,
                  .covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4,
                  .submap = SubmapId("s"),
                  .submap_from_camera = {},
                  .inliers = 50,
                  .rms_px = 1});
  EXPECT_FALSE(tracker.Pose(1).map_from_device) << "no odometry yet";
  tracker.PushOdometry(now, DeviceTime{seconds(2)});
  ASSERT_TRUE(tracker.Pose(1).map_from_device);
  EXPECT_LT(
      Difference(tracker.Pose(1).map_from_device->rigid(), (map_from_vo * now).rigid()).norm(),
      1e-6);
  EXPECT_THAT(tracker.SeenIn(), ElementsAre(SubmapId("s")));
  tracker.Reset();
  EXPECT_FALSE(tracker.Pose(1).map_from_device);
}

// A first fix places the device at once; when a better estimate differs, the shown pose walks
// there.
TEST(PoseTracker, CorrectionsNeverJump) {
  constexpr double kStep_s = 0.1;
  PoseTracker tracker({.half_life = std::chrono::duration<double>(0.01)}, {.max_speed_mps = 0.5});
  const auto fix = [&](double time_s, double x) {
    tracker.AddFix({.request = {},
                    .time = DeviceTime{milliseconds(static_cast<int>(1e3 * time_s))},
                    .device_from_camera = {},
                    .vo_from_device = {}},
                   {.map_from_camera = {Eigen::Quaterniond::Identity(), {x, 0, 0}},
                    .covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4,
                    .submap = SubmapId("s"),
                    .submap_from_camera = {},
                    .inliers = 50,
                    .rms_px = 1});
  };
  double time_s = 1;
  const auto live = [&] {
    time_s += kStep_s;
    tracker.PushOdometry({}, DeviceTime{milliseconds(static_cast<int>(1e3 * time_s + 0.5))});
    return tracker.Pose(1).map_from_device->translation().x();
  };
  fix(1, 10);
  double shown = live();
  EXPECT_NEAR(shown, 10, 0.01);
  for (int i = 0; i < 4; ++i) fix(time_s + 0.001 * i, 11);
  const double before = tracker.Pose(1).covariance(0, 0);
  for (int i = 0; i < 40; ++i) {
    const double next = live();
    EXPECT_LE(std::abs(next - shown), 0.5 * kStep_s + 1e-9);
    shown = next;
  }
  EXPECT_NEAR(shown, 11, 0.05);
  EXPECT_LT(tracker.Pose(1).covariance(0, 0), before) << "what was still to come was uncertainty";
}

TEST(Jpeg, RefusesSizesThatDoNotMatch) {
  const std::vector<std::uint8_t> pixels(12, 7);
  EXPECT_TRUE(EncodeJpeg(pixels, 4, 3, 85).ok());
  EXPECT_EQ(EncodeJpeg(pixels, 4, 4, 85).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(EncodeJpeg(pixels, -4, -3, 85).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace waymark::session

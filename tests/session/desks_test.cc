// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/desks.h"

#include <gmock/gmock.h>

namespace waymark::session {
namespace {

using internal::CommandDesk;
using internal::ImageDesk;
using internal::Instant;
using internal::JoinDesk;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::IsEmpty;
using testing::SizeIs;

constexpr RunId kRun{1}, kNextRun{2};
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
  EXPECT_FALSE(desk.TakeHelloDue(kStart + milliseconds(19)));
  for (const int due : {20, 60, 140, 300, 600, 900}) {
    EXPECT_FALSE(desk.TakeHelloDue(kStart + milliseconds(due - 1)));
    EXPECT_TRUE(desk.TakeHelloDue(kStart + milliseconds(due)));
  }
  EXPECT_EQ(desk.On(Accepted(3), kStart), JoinDesk::Outcome::kIgnored) << "an earlier life's";
  EXPECT_EQ(desk.On(Accepted(0xfffffffe), kStart), JoinDesk::Outcome::kJoined);
  EXPECT_EQ(desk.On(Accepted(0xfffffffe), kStart), JoinDesk::Outcome::kIgnored);
  EXPECT_FALSE(desk.TakeHelloDue(kStart + seconds(1)));
  EXPECT_TRUE(desk.TakePingDue(kStart));
}

TEST(JoinDesk, AServerOfAnEarlierProtocolIsNoServer) {
  JoinDesk desk(1);
  desk.TakeHelloDue(kStart);
  Welcome welcome = Accepted(1);
  welcome.protocol = kOldestProtocol - 1;
  EXPECT_EQ(desk.On(welcome, kStart), JoinDesk::Outcome::kRefused);
  EXPECT_FALSE(desk.IsConnected());
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
  EXPECT_EQ(desk.On(Accepted(1), kStart + seconds(3)), JoinDesk::Outcome::kIgnored)
      << "kept by the server since before the silence";
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

TEST(JoinDesk, ANewWayMeansJoiningAgainAtOnce) {
  JoinDesk desk(1);
  desk.TakeHelloDue(kStart);
  desk.Restart(kStart + milliseconds(10));
  EXPECT_TRUE(desk.TakeHelloDue(kStart + milliseconds(10)));
  EXPECT_EQ(desk.attempt(), 1u) << "nobody has answered yet";
  desk.On(Accepted(1), kStart + milliseconds(20));
  desk.Restart(kStart + seconds(1));
  EXPECT_FALSE(desk.IsConnected());
  EXPECT_TRUE(desk.TakeHelloDue(kStart + seconds(1)));
  EXPECT_EQ(desk.attempt(), 2u);
  EXPECT_EQ(desk.On(Accepted(2), kStart + seconds(1)), JoinDesk::Outcome::kJoined);
}

using Offered = ImageDesk::Offered;
constexpr std::size_t kBytes = 10'000;  // that an image would take

TEST(ImageDesk, ANewerOneTakesThePlaceOfAnOlderThatHasNotLeft) {
  ImageDesk desk(seconds(1), seconds(5));
  const DeviceTime t{seconds(10)};
  RequestNumber older{}, newer{};
  EXPECT_EQ(desk.Offer(Frame(t), kStart, 0, kBytes), Offered::kTaken);
  EXPECT_TRUE(desk.TakeFrame(older));
  desk.NoteSent(40'000, 640, kStart + milliseconds(3));
  const DeviceFrame next = Frame(t + seconds(1));
  EXPECT_EQ(desk.Offer(next, kStart, kBytes, kBytes), Offered::kRefused) << "it is there sooner";
  EXPECT_EQ(desk.Offer(next, kStart, 20'000, 40'000), Offered::kRefused) << "half has left";
  EXPECT_EQ(desk.Offer(next, kStart, kBytes + 1, kBytes), Offered::kInsteadOfOlder);
  EXPECT_FALSE(desk.TakeMatch(older)) << "it may have arrived whole after all, too late";
  EXPECT_EQ(desk.Offer(Frame(t + seconds(2)), kStart, kBytes + 1, kBytes), Offered::kRefused)
      << "the newer one is not even encoded";
  EXPECT_TRUE(desk.TakeFrame(newer));
  desk.NoteSent(30'000, 320, kStart + milliseconds(4));
  EXPECT_EQ(desk.Offer(Frame(t + seconds(2)), kStart, 29'000, 30'000), Offered::kRefused)
      << "or none would ever arrive";
  desk.NoteSent(9'000, 320, kStart + milliseconds(5));
  const auto match = desk.TakeMatch(newer);
  ASSERT_TRUE(match);
  EXPECT_EQ(match->image_bytes, 9'000u);
  EXPECT_EQ(match->width_px, 320);
  EXPECT_EQ(match->sent, kStart + milliseconds(5));
}

TEST(ImageDesk, OneImageIsUnderWayAtATime) {
  ImageDesk desk(seconds(1), seconds(5));
  const DeviceTime t{seconds(10)};
  RequestNumber first{}, second{};
  EXPECT_FALSE(desk.TakeFrame(first));
  EXPECT_EQ(desk.Offer(Frame(t), kStart, 0, kBytes), Offered::kTaken);
  EXPECT_TRUE(desk.TakeFrame(first));
  EXPECT_EQ(desk.Offer(Frame(t + seconds(2)), kStart, 0, kBytes), Offered::kRefused)
      << "one is under way";
  EXPECT_FALSE(desk.TakeMatch(RequestNumber{99}));
  const auto match = desk.TakeMatch(first);
  ASSERT_TRUE(match);
  EXPECT_EQ(match->frame.time, t);
  EXPECT_EQ(match->pushed, kStart);
  EXPECT_FALSE(desk.TakeMatch(first)) << "answered twice counts once";
  EXPECT_EQ(desk.Offer(Frame(t + milliseconds(900)), kStart, 0, kBytes), Offered::kRefused)
      << "too early";
  EXPECT_EQ(desk.Offer(Frame(t + seconds(1)), kStart, 0, kBytes), Offered::kTaken);
  EXPECT_TRUE(desk.TakeFrame(second));
  EXPECT_NE(first, second);
  EXPECT_FALSE(desk.TakeTimeout(kStart + milliseconds(4999)));
  EXPECT_TRUE(desk.TakeTimeout(kStart + seconds(5)));
  EXPECT_FALSE(desk.TakeMatch(second)) << "too late";
  EXPECT_EQ(desk.Offer(Frame(t - seconds(5)), kStart, 0, kBytes), Offered::kTaken)
      << "a clock set back is not early";
}

TEST(CommandDesk, RepeatsUntilAnswered) {
  CommandDesk desk;
  const AnchorCommand command{.request = UuidFromBits(1, 1),
                              .anchor = AnchorId(FormatUuid(UuidFromBits(1, 1)))};
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

}  // namespace
}  // namespace waymark::session

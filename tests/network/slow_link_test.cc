// SPDX-License-Identifier: Apache-2.0
// What waits on a slow link, and what makes way: anywhere, through a relay.
#include "tests/network/slow_relay.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>

#include "tests/session/session_fixture.h"

namespace waymark::network {
namespace {

using session::support::Eventually;

class SlowLinkTest : public session::support::SessionTest {
 protected:
  void SetUp() override {
    StartServer();
    if (!gateway_) StartGateway();
    auto relay = SlowRelay::Start(gateway_->port(), *FindProfile("none"), 1);
    ASSERT_TRUE(relay.ok());
    relay_ = *std::move(relay);
  }
  ~SlowLinkTest() override { relay_.reset(); }

  session::DeviceOptions Slow(const std::string& name) const {
    session::DeviceOptions options = MakeDeviceOptions(name);
    options.server = fmt::format("ws://127.0.0.1:{}", relay_->port());
    return options;
  }

  std::unique_ptr<SlowRelay> relay_;
};

/// A frame of which no JPEG is small.
session::DeviceFrame NoisyFrame(int side_px) {
  const std::array<double, 3> parameters{500, side_px / 2.0, side_px / 2.0};
  session::DeviceFrame frame{
      .width_px = side_px,
      .height_px = side_px,
      .pixels = std::vector<std::uint8_t>(static_cast<std::size_t>(side_px * side_px)),
      .camera = *CameraModel::Create(CameraKind::kSimplePinhole, side_px, side_px, parameters),
      .device_from_camera = session::support::DeviceFromCamera(),
      .vo_from_device = {Eigen::Quaterniond::Identity(), {3, 3, 1}},
      .time = {}};
  std::uint32_t state = 1;
  for (std::uint8_t& pixel : frame.pixels) {
    state = state * 1664525 + 1013904223;
    pixel = static_cast<std::uint8_t>(state >> 24);
  }
  frame.gnss = TangentPlane(session::support::MapOrigin()).ToGeo(Point<Map>(3, 4, 1));
  return frame;
}

constexpr Profile kThin{
    .name = "thin",
    .source = "",
    .up = {.delay = milliseconds(5), .rate_bps = 1e6, .queue = milliseconds(60'000)},
    .down = {.delay = milliseconds(5)}};

/// Offers this frame again and again until so many of more than 20 kB have been answered.
bool ShowUntilFound(session::DeviceSession& device, session::DeviceFrame& frame, int count) {
  const auto large = [&] {
    const auto timings = device.Statistics().keyframe_timings;
    return std::count_if(timings.begin(), timings.end(),
                         [](const auto& timing) { return timing.image_bytes > 20'000; });
  };
  const auto wanted = large() + count;
  return Eventually([&] {
    frame.time = session::support::StandingPhone::Now();
    (void)device.PushFrame(frame);
    return large() >= wanted;
  });
}

TEST_F(SlowLinkTest, PosesDoNotWaitBehindAnImage) {
  session::DeviceOptions options = Slow("Anna");
  options.keyframe_sizes = session::KeyframeSizes::kAsTaken;
  options.jpeg_quality = 95;
  const auto anna = Join(options), ben = Join("Ben");
  session::support::StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  session::DeviceFrame frame = NoisyFrame(700);  // 500 kB are four seconds of that link
  relay_->SetProfile(kThin);
  int rounds = 0, fresh = 0;
  std::atomic<bool> has_arrived = false;
  std::thread moving([&] {
    while (!has_arrived) {
      anna->PushOdometry(phone.VoFromDevice(), session::support::StandingPhone::Now());
      const auto seen = session::support::FindOther(*ben, anna->id());
      ++rounds;
      if (seen && seen->age.count() < 1) ++fresh;
      std::this_thread::sleep_for(milliseconds(5));
    }
  });
  EXPECT_TRUE(ShowUntilFound(*anna, frame, 1));
  has_arrived = true;
  moving.join();
  EXPECT_GT(fresh, rounds / 2) << "of " << rounds << ": poses are heard while an image goes";
}

TEST_F(SlowLinkTest, ANewerImageTakesThePlaceOfOneThatCannotLeave) {
  const auto anna = Join(Slow("Anna"));
  session::DeviceFrame frame = NoisyFrame(400);
  ASSERT_TRUE(ShowUntilFound(*anna, frame, 1));
  // A link that is silent for 1.2 s is given up; on a busy machine before the next image is made.
  for (int attempt = 0; attempt < 30 && anna->Statistics().superseded == 0; ++attempt) {
    relay_->Cut(true);
    const auto end = std::chrono::steady_clock::now() + milliseconds(1000);
    while (std::chrono::steady_clock::now() < end && anna->Statistics().superseded == 0) {
      frame.time = session::support::StandingPhone::Now();
      (void)anna->PushFrame(frame);
      std::this_thread::sleep_for(milliseconds(5));
    }
    relay_->Cut(false);
    ASSERT_TRUE(ShowUntilFound(*anna, frame, 1)) << "whatever was cut in two";
  }
  EXPECT_GT(anna->Statistics().superseded, 0);
}

TEST_F(SlowLinkTest, ImagesAreSmallerOnAThinnerLink) {
  session::DeviceOptions options = Slow("Anna");
  options.keyframe_interval = milliseconds(300);  // not to be found has a price
  const auto anna = Join(options);
  session::DeviceFrame frame = NoisyFrame(480);
  ASSERT_TRUE(ShowUntilFound(*anna, frame, 6));
  // The largest: where the processors are busy, a wide link seems slow at times.
  std::size_t on_a_wide_link = 0;
  for (const auto& timing : anna->Statistics().keyframe_timings) {
    on_a_wide_link = std::max(on_a_wide_link, timing.image_bytes);
  }
  relay_->SetProfile(kThin);
  ASSERT_TRUE(ShowUntilFound(*anna, frame, 5));
  EXPECT_LT(anna->Statistics().keyframe_timings.back().image_bytes, on_a_wide_link);
}

/// The networks of phones, where they cannot be emulated packet by packet too.
class SlowNetwork : public SlowLinkTest, public testing::WithParamInterface<std::string> {};
INSTANTIATE_TEST_SUITE_P(Profiles, SlowNetwork, testing::Values("4g", "3g", "crowded"),
                         [](const auto& tested) { return tested.param; });

// anna (slow)  join . localise . place . . cut . . . . . . . joined: she knows what she missed
// ben          join . . . . . . . . . sees . she is gone . place . delete . . sees her again
TEST_P(SlowNetwork, PhonesShareAnchorsAndMakeUpForWhatTheyMissed) {
  relay_->SetProfile(*FindProfile(GetParam()));
  const auto anna = Join(Slow("Anna")), ben = Join("Ben");
  session::support::StandingPhone phone(*anna, {3, 4, 1}), other(*ben, {5, 4, 1});
  ASSERT_TRUE(phone.Localise());
  ASSERT_TRUE(other.Localise());
  const auto hers = anna->PlaceAnchor(session::support::kAhead, "note", "hers");
  ASSERT_TRUE(hers.ok()) << ToString(hers.error());
  const auto knows = [](session::DeviceSession& device, const session::SharedAnchor& anchor) {
    return session::support::FindAnchor(device, anchor.id).has_value();
  };
  EXPECT_TRUE(Eventually([&] { return knows(*ben, *hers); }));
  EXPECT_TRUE(Eventually([&] { return session::support::Sees(*ben, anna->id()); }));
  relay_->Cut(true);
  EXPECT_TRUE(Eventually([&] { return !session::support::Sees(*ben, anna->id()); }));
  const auto missed = ben->PlaceAnchor(session::support::kAhead, "note", "missed");
  ASSERT_TRUE(missed.ok()) << ToString(missed.error());
  ASSERT_TRUE(ben->DeleteAnchor(*hers).ok());
  relay_->Cut(false);
  EXPECT_TRUE(Eventually([&] { return knows(*anna, *missed) && !knows(*anna, *hers); }));
  EXPECT_TRUE(Eventually([&] { return session::support::Sees(*ben, anna->id()); }));
  EXPECT_TRUE(anna->PlaceAnchor(session::support::kAhead, "note", "after").ok());
}

}  // namespace
}  // namespace waymark::network

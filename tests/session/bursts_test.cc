// SPDX-License-Identifier: Apache-2.0
// A phone that sees too little in each picture, with a real localiser and map.
#include <numbers>

#include "tests/session/pictured_session.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::kPictureHeight;
using support::kPictureWidth;

/// Shows 11 landmarks where the phone looks, of 15 that are needed.
constexpr int kStripWidth = 28;

/// A phone under the one picture that the map was made of, with its camera nearly covered: a strip
/// is left. Turned half around it sees the picture upside down.
class StarvedPhone {
 public:
  explicit StarvedPhone(DeviceSession& session) : session_(session) {}

  /// In steps that odometry takes.
  void TurnHalfAround() {
    constexpr int kSteps = 18;
    for (int i = 0; i < kSteps; ++i) {
      yaw_rad_ += std::numbers::pi / kSteps;
      session_.PushOdometry(VoFromDevice(), support::StandingPhone::Now());
    }
    is_turned_ = !is_turned_;
  }
  /// Odometry begins anew, somewhere else.
  void LoseOdometry() {
    begin_in_vo_ += Eigen::Vector3d(40, 7, -3);
    session_.PushOdometry(VoFromDevice(), support::StandingPhone::Now());
  }
  /// From now on odometry says that it turns by that much less than it does.
  void Misjudge(double yaw_rad) { yaw_rad_ -= yaw_rad; }

  /// Looks until an image that was taken since is answered. The strip begins at that column.
  bool Look(int strip_begin) {
    const std::vector<std::uint8_t> pixels = Strip(strip_begin);
    const int answers = CountAnswers();
    return Eventually([&] {
      const DeviceTime now = support::StandingPhone::Now();
      session_.PushOdometry(VoFromDevice(), now);
      EXPECT_TRUE(session_
                      .PushFrame({.width_px = kPictureWidth,
                                  .height_px = kPictureHeight,
                                  .pixels = pixels,
                                  .camera = support::TestCamera(),
                                  .device_from_camera = {},
                                  .vo_from_device = VoFromDevice(),
                                  .time = now})
                      .ok());
      return CountAnswers() >= answers + 2;  // the first may be of one that was under way
    });
  }
  bool LookLeft() { return Look(80); }
  bool LookRight() { return Look(260); }
  /// Looks left and right in turns. A machine that stands still for seconds is a pause to odometry,
  /// so once may not do.
  bool LookAroundUntilFound() {
    return Eventually([&] {
      if (!LookLeft()) return false;
      TurnHalfAround();
      if (!LookRight()) return false;
      TurnHalfAround();
      return session_.Statistics().fixes > 0;
    });
  }

 private:
  int CountAnswers() const {
    const DeviceStatistics statistics = session_.Statistics();
    return statistics.fixes + statistics.refusals;
  }

  Transform<Vo, Device> VoFromDevice() const {
    return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad_, Eigen::Vector3d::UnitZ())),
            begin_in_vo_};
  }

  std::vector<std::uint8_t> Strip(int begin) const {
    std::vector<std::uint8_t> pixels = support::Picture();
    for (int v = 0; v < kPictureHeight; ++v) {
      for (int u = 0; u < kPictureWidth; ++u) {
        const bool is_seen = u >= begin && u < begin + kStripWidth;
        if (!is_seen) pixels[static_cast<std::size_t>(v * kPictureWidth + u)] = 128;
      }
    }
    if (is_turned_) std::reverse(pixels.begin(), pixels.end());
    return pixels;
  }

  DeviceSession& session_;
  double yaw_rad_ = 0.4;
  Eigen::Vector3d begin_in_vo_{3, 4, 5};
  bool is_turned_ = false;
};

class Bursts : public support::PicturedSession {
 protected:
  Bursts() { Serve(); }

  std::unique_ptr<DeviceSession> JoinWith(int burst_images) const {
    DeviceOptions options = MakeDeviceOptions("Anna");
    options.burst_images = burst_images;
    options.keyframe_content = KeyframeContent::kFeatures;
    return Join(options);
  }
};

TEST_F(Bursts, FindAPhoneThatNoImageFindsAlone) {
  const auto anna = JoinWith(2);
  StarvedPhone phone(*anna);
  ASSERT_TRUE(phone.LookLeft());
  EXPECT_EQ(anna->Statistics().fixes, 0);
  ASSERT_TRUE(phone.LookAroundUntilFound());
  const DeviceStatistics statistics = anna->Statistics();
  EXPECT_GE(statistics.burst_fixes, 1);
  EXPECT_EQ(statistics.burst_fixes, statistics.fixes) << "none was found alone";
  ASSERT_FALSE(statistics.keyframe_timings.empty());
  EXPECT_EQ(statistics.keyframe_timings.back().images, 2);
  ASSERT_TRUE(anna->Pose().map_from_device);
  EXPECT_LT(anna->Pose().map_from_device->translation().norm(), 0.2);
}

TEST_F(Bursts, AreNotAskedUnlessThePhoneWantsThem) {
  const auto anna = JoinWith(1);
  StarvedPhone phone(*anna);
  for (int turn = 0; turn < 2; ++turn) {
    ASSERT_TRUE(phone.LookLeft());
    ASSERT_TRUE(phone.LookRight());
    phone.TurnHalfAround();
  }
  EXPECT_EQ(anna->Statistics().fixes, 0);
}

TEST_F(Bursts, DoNotSpanALossOfOdometry) {
  const auto anna = JoinWith(2);
  StarvedPhone phone(*anna);
  ASSERT_TRUE(phone.LookLeft());
  phone.TurnHalfAround();
  phone.LoseOdometry();
  ASSERT_TRUE(phone.LookRight());
  EXPECT_EQ(anna->Statistics().fixes, 0);
  phone.TurnHalfAround();
  EXPECT_TRUE(phone.LookAroundUntilFound()) << "both in the new odometry";
}

TEST_F(Bursts, AreRefusedWhereOdometryIsWrong) {
  const auto anna = JoinWith(2);
  StarvedPhone phone(*anna);
  ASSERT_TRUE(phone.LookLeft());
  phone.Misjudge(0.3);
  phone.TurnHalfAround();
  ASSERT_TRUE(phone.LookRight());
  EXPECT_EQ(anna->Statistics().fixes, 0);
}

TEST_F(Bursts, GoOnAfterTheServerCameBack) {
  const auto anna = JoinWith(2);
  StarvedPhone phone(*anna);
  ASSERT_TRUE(phone.LookLeft());
  StopServer();
  Serve();
  ASSERT_TRUE(phone.LookLeft()) << "the new server knows nothing of the earlier one's images";
  EXPECT_EQ(anna->Statistics().fixes, 0);
  EXPECT_TRUE(phone.LookAroundUntilFound());
}

TEST_F(Bursts, OfTooManyImagesAreNoOption) {
  DeviceOptions options = MakeDeviceOptions("Anna");
  for (const int images : {0, -1, 17}) {
    options.burst_images = images;
    EXPECT_EQ(DeviceSession::Join(options).error().code, ErrorCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace waymark::session

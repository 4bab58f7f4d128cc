// SPDX-License-Identifier: Apache-2.0
// A phone that localises by itself, and one that sends features, with a real localiser and map.
#include "tests/session/pictured_session.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::kPictureHeight;
using support::kPictureWidth;
using support::seconds;

/// A phone that stands at the map's origin and sees the one picture that the map was made of.
class LookingPhone {
 public:
  explicit LookingPhone(DeviceSession& session) : session_(session) {}

  void Live() {
    const DeviceTime now = support::StandingPhone::Now();
    session_.PushOdometry({}, now);
    EXPECT_TRUE(session_
                    .PushFrame({.width_px = kPictureWidth,
                                .height_px = kPictureHeight,
                                .pixels = picture_,
                                .camera = support::TestCamera(),
                                .device_from_camera = {},
                                .vo_from_device = {},
                                .time = now})
                    .ok());
  }
  bool LivesUntil(const std::function<bool()>& condition) {
    return Eventually([&] {
      Live();
      return condition();
    });
  }
  /// Whether it knows where it is, by that source.
  bool IsFixedBy(FixSource source) const {
    const DevicePose pose = session_.Pose();
    return pose.state == localiser::AlignmentState::kFixed && pose.fix_source == source &&
           pose.map_from_device->translation().norm() < 0.05;
  }

 private:
  DeviceSession& session_;
  const std::vector<std::uint8_t> picture_ = support::Picture();
};

class Tiles : public support::PicturedSession {
 protected:
  DeviceOptions WithTile() const {
    DeviceOptions options = MakeDeviceOptions("Anna");
    options.tile_folder = disk_.map().folder();
    return options;
  }
};

TEST_F(Tiles, ServeWhileTheServerIsAway) {
  Serve();
  const auto anna = Join(WithTile());
  LookingPhone phone(*anna);
  ASSERT_TRUE(phone.LivesUntil([&] { return phone.IsFixedBy(FixSource::kServer); }));
  EXPECT_EQ(anna->Statistics().tile_fixes, 0) << "the server answers";
  EXPECT_FALSE(is_last_query_features_);
  StopServer();
  ASSERT_TRUE(phone.LivesUntil([&] { return phone.IsFixedBy(FixSource::kTile); }));
  EXPECT_EQ(anna->Pose().epoch, 1u);
  const int fixes = anna->Statistics().fixes;
  Serve();
  ASSERT_TRUE(phone.LivesUntil(
      [&] { return phone.IsFixedBy(FixSource::kServer) && anna->Statistics().fixes > fixes; }));
  EXPECT_EQ(anna->Statistics().tile_refusals, 0);
}

TEST_F(Tiles, LetAPhoneBeginAlone) {
  Serve();
  StopServer();
  DeviceOptions options = WithTile();
  options.request_timeout = std::chrono::milliseconds(300);
  const auto anna = Join(options);
  ASSERT_NE(anna, nullptr);
  EXPECT_EQ(anna->Statistics().joins, 0);
  EXPECT_EQ(anna->DescribeMap().id, disk_.map().description().id);
  LookingPhone phone(*anna);
  ASSERT_TRUE(phone.LivesUntil([&] { return phone.IsFixedBy(FixSource::kTile); }));
  EXPECT_EQ(anna->PlaceAnchor({}, "note", "alone").error().code, ErrorCode::kUnavailable);
  Serve();
  bool is_always_fixed = true;
  ASSERT_TRUE(phone.LivesUntil([&] {
    is_always_fixed = is_always_fixed && anna->Pose().state == localiser::AlignmentState::kFixed;
    return anna->Statistics().joins == 1 && phone.IsFixedBy(FixSource::kServer);
  }));
  EXPECT_TRUE(is_always_fixed) << "it is the same map: its own fixes stay";
  EXPECT_TRUE(anna->PlaceAnchor({}, "note", "together").ok());
}

TEST_F(Tiles, OfAnotherReleaseAreNotAsked) {
  Serve(2);
  DeviceOptions options = WithTile();
  options.request_timeout = seconds(3);
  const auto anna = Join(options);
  LookingPhone phone(*anna);
  ASSERT_TRUE(phone.LivesUntil([&] { return phone.IsFixedBy(FixSource::kServer); }));
  StopServer();
  EXPECT_FALSE(anna->PlaceAnchor({}, "note", "").ok()) << "by now the way is known to be lost";
  for (int moment = 0; moment < 20; ++moment) phone.Live();
  const int fixes = anna->Statistics().fixes;
  Serve(2);
  ASSERT_TRUE(phone.LivesUntil([&] { return anna->Statistics().fixes > fixes; }));
  EXPECT_EQ(anna->Statistics().tile_fixes + anna->Statistics().tile_refusals, 0);
}

TEST_F(Tiles, ThatAreNoneAreRefused) {
  Serve();
  DeviceOptions options = WithTile();
  options.tile_folder = folder_ / "nothing";
  EXPECT_EQ(DeviceSession::Join(options).error().code, ErrorCode::kNotFound);
}

TEST_F(Tiles, FeaturesInsteadOfPixelsAreLocalisedAsWell) {
  Serve();
  DeviceOptions options = MakeDeviceOptions("Anna");
  options.keyframe_content = KeyframeContent::kFeatures;
  options.max_sent_features = 200;
  const auto anna = Join(options);
  LookingPhone phone(*anna);
  ASSERT_TRUE(phone.LivesUntil([&] { return phone.IsFixedBy(FixSource::kServer); }));
  EXPECT_TRUE(is_last_query_features_);
  EXPECT_LE(last_query_bytes_, 24u + 200 * 144);
  EXPECT_EQ(anna->Statistics().keyframe_timings.back().image_bytes, last_query_bytes_);
}

}  // namespace
}  // namespace waymark::session

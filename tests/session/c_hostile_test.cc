// SPDX-License-Identifier: Apache-2.0
// Whatever an app hands over is answered with a code.
#include <atomic>
#include <limits>
#include <thread>

#include "tests/session/c_phone.h"

namespace waymark::session {
namespace {

using support::At;
using support::CPhone;
using support::Sized;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class CHostile : public support::SessionTest {
 protected:
  void SetUp() override {
    StartServer();
    phone_.emplace(MakeDeviceOptions("Anna"));
    ASSERT_EQ(phone_->joined(), WAYMARK_OK) << phone_->message();
    session_ = phone_->session();
  }

  std::optional<CPhone> phone_;
  WaymarkSession session_ = 0;
};

TEST_F(CHostile, NullIsAnswered) {
  std::size_t count = 0;
  const WaymarkTransform here = At(0, 0, 0);
  auto anchor = Sized<WaymarkAnchor>();
  for (const WaymarkStatus status : {waymark_options_create(nullptr),
                                     waymark_session_join(0, nullptr),
                                     waymark_standing(session_, nullptr),
                                     waymark_kick(session_, nullptr, "x"),
                                     waymark_kick(session_, "x", nullptr),
                                     waymark_readmit(session_, nullptr),
                                     waymark_push_odometry(session_, nullptr, 0),
                                     waymark_push_frame(session_, nullptr),
                                     waymark_pose(session_, nullptr),
                                     waymark_session_time(session_, 0, nullptr),
                                     waymark_others(session_, nullptr, 5, &count),
                                     waymark_others(session_, nullptr, 0, nullptr),
                                     waymark_place_anchor(session_, nullptr, nullptr),
                                     waymark_move_anchor(session_, nullptr, &here, nullptr),
                                     waymark_move_anchor(session_, &anchor, nullptr, nullptr),
                                     waymark_delete_anchor(session_, nullptr, nullptr),
                                     waymark_begin_place_anchor(session_, nullptr, nullptr),
                                     waymark_begin_move_anchor(session_, nullptr, &here),
                                     waymark_begin_move_anchor(session_, &anchor, nullptr),
                                     waymark_begin_delete_anchor(session_, nullptr),
                                     waymark_find_anchor(session_, nullptr, &anchor),
                                     waymark_anchors(session_, nullptr, 1, &count),
                                     waymark_anchor_payload(session_, "x", nullptr, 0, nullptr),
                                     waymark_next_event(session_, nullptr)}) {
    EXPECT_EQ(status, WAYMARK_INVALID_ARGUMENT);
    EXPECT_STRNE(waymark_error_message(), "");
  }
  EXPECT_EQ(waymark_others(session_, nullptr, 0, &count), WAYMARK_OK);
  EXPECT_STREQ(waymark_error_message(), "") << "of the latest call only";
}

TEST_F(CHostile, HandlesThatAreNoneAreAnswered) {
  WaymarkOptions options = 0;
  ASSERT_EQ(waymark_options_create(&options), WAYMARK_OK);
  const WaymarkSession destroyed = [&] {
    const CPhone other(MakeDeviceOptions("Ben"));
    return other.session();
  }();
  ASSERT_NE(destroyed, 0u);
  WaymarkSession joined = 0;
  std::size_t count = 0;
  auto pose = Sized<WaymarkPose>();
  for (const WaymarkSession none : {std::uint64_t{0}, ~std::uint64_t{0}, options, destroyed}) {
    EXPECT_EQ(waymark_pose(none, &pose), WAYMARK_NO_SUCH_HANDLE);
    EXPECT_EQ(waymark_others(none, nullptr, 0, &count), WAYMARK_NO_SUCH_HANDLE);
    EXPECT_EQ(waymark_session_destroy(none), WAYMARK_NO_SUCH_HANDLE);
    EXPECT_THAT(waymark_error_message(), HasSubstr("session"));
  }
  EXPECT_EQ(waymark_session_join(session_, &joined), WAYMARK_NO_SUCH_HANDLE);
  EXPECT_EQ(waymark_options_destroy(options), WAYMARK_OK);
  EXPECT_EQ(waymark_options_destroy(options), WAYMARK_NO_SUCH_HANDLE);
  EXPECT_EQ(waymark_options_set_text(options, "room", "x"), WAYMARK_NO_SUCH_HANDLE);
  EXPECT_EQ(joined, 0u);
}

TEST_F(CHostile, OptionsAreChecked) {
  WaymarkOptions options = 0;
  ASSERT_EQ(waymark_options_create(&options), WAYMARK_OK);
  EXPECT_EQ(waymark_options_set_text(options, "colour", "red"), WAYMARK_NOT_FOUND);
  EXPECT_THAT(waymark_error_message(), HasSubstr("security_folder"));
  EXPECT_EQ(waymark_options_set_text(options, nullptr, "red"), WAYMARK_INVALID_ARGUMENT);
  EXPECT_EQ(waymark_options_set_text(options, "room", nullptr), WAYMARK_INVALID_ARGUMENT);
  EXPECT_EQ(waymark_options_set_text(options, "room", std::string(5000, 'x').c_str()),
            WAYMARK_INVALID_ARGUMENT);
  for (const double number : {-1.0, 231.0, 0.5, kNaN, HUGE_VAL}) {
    EXPECT_EQ(waymark_options_set_number(options, "dds_domain", number), WAYMARK_INVALID_ARGUMENT);
  }
  EXPECT_EQ(waymark_options_destroy(options), WAYMARK_OK);
}

TEST_F(CHostile, SizesOfOtherVersionsAreUnderstoodOrRefused) {
  auto pose = Sized<WaymarkPose>();
  for (const std::uint32_t size : {0u, 8u, 1u << 20, std::uint32_t{sizeof(WaymarkPose)} + 1}) {
    pose.struct_size = size;
    EXPECT_EQ(waymark_pose(session_, &pose), WAYMARK_INVALID_ARGUMENT) << size;
  }
  // A later header's struct: what this library does not know becomes zero.
  struct Longer {
    WaymarkPose pose;
    std::uint64_t later;
  } longer{.pose = {}, .later = 7};
  longer.pose.struct_size = sizeof(Longer);
  EXPECT_EQ(waymark_pose(session_, &longer.pose), WAYMARK_OK);
  EXPECT_EQ(longer.pose.struct_size, sizeof(Longer));
  EXPECT_EQ(longer.later, 0u);
  // Something only a later library understands is not silently left out.
  struct LongerFrame {
    WaymarkFrame frame;
    std::uint64_t later;
  } frame{.frame = phone_->Frame(), .later = 7};
  frame.frame.struct_size = sizeof(LongerFrame);
  EXPECT_EQ(waymark_push_frame(session_, &frame.frame), WAYMARK_UNSUPPORTED);
  frame.later = 0;
  EXPECT_EQ(waymark_push_frame(session_, &frame.frame), WAYMARK_OK) << waymark_error_message();
}

TEST_F(CHostile, FramesAreChecked) {
  const auto refused = [&](const std::function<void(WaymarkFrame&)>& spoil) {
    WaymarkFrame frame = phone_->Frame();
    spoil(frame);
    return waymark_push_frame(session_, &frame);
  };
  ASSERT_EQ(refused([](auto&) {}), WAYMARK_OK) << waymark_error_message();
  const auto spoilers = std::to_array<std::function<void(WaymarkFrame&)>>({
      [](auto& f) { f.image = nullptr; },
      [](auto& f) { f.image_bytes -= 1; },
      [](auto& f) { f.image_bytes = 0; },
      [](auto& f) { f.row_bytes = 63; },
      [](auto& f) { f.row_bytes = std::numeric_limits<std::int32_t>::max(); },
      [](auto& f) { f.row_bytes = std::numeric_limits<std::int32_t>::min(); },
      [](auto& f) { f.width_px = 0; },
      [](auto& f) { f.height_px = -48; },
      [](auto& f) { f.width_px = f.height_px = std::numeric_limits<std::int32_t>::max(); },
      [](auto& f) { f.format = 9; },
      [](auto& f) { f.camera_kind = -1; },
      [](auto& f) { f.camera_kind = 5; },
      [](auto& f) { f.camera_parameters[0] = 0; },
      [](auto& f) { f.camera_parameters[1] = kNaN; },
      [](auto& f) { f.device_from_camera.rotation_xyzw[0] = 3; },
      [](auto& f) { f.device_from_camera = {}; },
      [](auto& f) { f.vo_from_device.translation_m[2] = kNaN; },
      [](auto& f) { f.has_up = 1; },
      [](auto& f) { f.latitude_deg = 91; },
      [](auto& f) { f.longitude_deg = kNaN; },
      [](auto& f) { f.longitude_deg = 200; },
      [](auto& f) { f.gnss_sigma_m = 0; },
  });
  for (std::size_t i = 0; i < spoilers.size(); ++i) {
    EXPECT_EQ(refused(spoilers[i]), WAYMARK_INVALID_ARGUMENT) << "spoiler " << i;
  }
  EXPECT_EQ(refused([](auto& f) { f.format = WAYMARK_JPEG; }), WAYMARK_CORRUPT) << "it is none";
}

TEST_F(CHostile, AnchorsAreChecked) {
  ASSERT_TRUE(phone_->Localise());
  auto placement = Sized<WaymarkPlacement>();
  placement.device_from_anchor = At(1, 0, 0);
  EXPECT_EQ(waymark_place_anchor(session_, &placement, nullptr), WAYMARK_INVALID_ARGUMENT);
  const std::string long_kind(300, 'k');
  placement.kind = long_kind.c_str();
  EXPECT_EQ(waymark_place_anchor(session_, &placement, nullptr), WAYMARK_INVALID_ARGUMENT);
  placement.kind = "note";
  placement.payload_bytes = 1;
  EXPECT_EQ(waymark_place_anchor(session_, &placement, nullptr), WAYMARK_INVALID_ARGUMENT);
  placement.payload = "x";
  placement.payload_bytes = ~std::uint64_t{0};
  EXPECT_EQ(waymark_place_anchor(session_, &placement, nullptr), WAYMARK_INVALID_ARGUMENT);
  auto anchor = Sized<WaymarkAnchor>();
  std::memset(anchor.anchor, 'x', sizeof(anchor.anchor));  // it does not end
  EXPECT_EQ(waymark_delete_anchor(session_, &anchor, nullptr), WAYMARK_INVALID_ARGUMENT);
}

TEST_F(CHostile, ASessionMayBeDestroyedWhileOthersUseIt) {
  ASSERT_TRUE(phone_->Localise());
  std::atomic<int> gone = 0;
  std::vector<std::jthread> users;
  for (int user = 0; user < 3; ++user) {
    users.emplace_back([&] {
      auto pose = Sized<WaymarkPose>();
      auto event = Sized<WaymarkEvent>();
      while (waymark_pose(session_, &pose) == WAYMARK_OK) {
        (void)waymark_next_event(session_, &event);
        (void)phone_->Place("x", nullptr);
      }
      ++gone;
    });
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(waymark_session_destroy(session_), WAYMARK_OK);
  users.clear();
  EXPECT_EQ(gone, 3);
  EXPECT_EQ(waymark_session_destroy(session_), WAYMARK_NO_SUCH_HANDLE);
}

}  // namespace
}  // namespace waymark::session

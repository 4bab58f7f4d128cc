// SPDX-License-Identifier: Apache-2.0
// The device library as apps in other languages use it.
#include <fstream>

#include "tests/session/c_phone.h"
#include "tests/session/peer.h"

namespace waymark::session {
namespace {

using support::At;
using support::CPhone;
using support::Eventually;
using support::kAhead;
using support::Sized;
using support::StandingPhone;
using testing::HasSubstr;

class CInterface : public support::SessionTest {};

TEST_F(CInterface, JoinsIsLocalisedAndSeesTheOthers) {
  StartServer();
  const auto ben = Join("Ben");
  StandingPhone ben_phone(*ben, {6, 4, 1});
  ASSERT_TRUE(ben_phone.Localise());
  const CPhone anna(MakeDeviceOptions("Anna"));
  ASSERT_EQ(anna.joined(), WAYMARK_OK) << anna.message();
  EXPECT_EQ(anna.Pose().state, WAYMARK_NEVER);
  EXPECT_EQ(anna.Pose().has_pose, 0);
  ASSERT_TRUE(anna.Localise());
  const WaymarkPose pose = anna.Pose();
  EXPECT_EQ(pose.has_pose, 1);
  EXPECT_EQ(pose.epoch, 1u);
  EXPECT_NEAR(pose.map_from_device.translation_m[0], 3, 1e-3);
  EXPECT_NEAR(pose.map_from_device.rotation_xyzw[3], 1, 1e-6);
  EXPECT_GT(pose.covariance[0], 0);
  std::int64_t session_time_ns = 0;
  EXPECT_EQ(waymark_session_time(anna.session(), waymark_steady_time_ns(), &session_time_ns),
            WAYMARK_OK);

  const std::string anna_id = anna.Standing().device;
  EXPECT_TRUE(Eventually([&] {
    anna.Live();
    const auto seen = support::FindOther(*ben, DeviceId(anna_id));
    return seen && seen->name == "Anna" && seen->map_from_device;
  })) << "its pose is shared";
  EXPECT_TRUE(anna.Hears(WAYMARK_DEVICE_CAME, ben->id().text()));
  std::array<WaymarkOther, 2> others{};
  others[0].struct_size = sizeof(WaymarkOther);
  std::size_t count = 0;
  EXPECT_TRUE(Eventually([&] {
    ben_phone.Live();
    EXPECT_EQ(waymark_others(anna.session(), others.data(), 2, &count), WAYMARK_OK);
    return count == 1 && others[0].has_pose != 0;
  }));
  EXPECT_STREQ(others[0].name, "Ben");
  EXPECT_EQ(others[0].device, ben->id().text());
  EXPECT_NEAR(others[0].map_from_device.translation_m[0], 6, 0.01);
  EXPECT_EQ(waymark_others(anna.session(), nullptr, 0, &count), WAYMARK_TOO_SMALL);
  EXPECT_EQ(count, 1u);
  ben->Leave();
  EXPECT_TRUE(anna.Hears(WAYMARK_DEVICE_LEFT, ben->id().text()));
}

TEST_F(CInterface, AnchorsAreSharedAndConflictsSayWhatStands) {
  StartServer();
  const auto ben = Join("Ben");
  StandingPhone ben_phone(*ben, {6, 4, 1});
  ASSERT_TRUE(ben_phone.Localise());
  const CPhone anna(MakeDeviceOptions("Anna"));
  EXPECT_EQ(anna.Place("too early", nullptr), WAYMARK_UNAVAILABLE);
  EXPECT_THAT(waymark_error_message(), HasSubstr("not been localised"));
  ASSERT_TRUE(anna.Localise());
  auto placed = Sized<WaymarkAnchor>();
  ASSERT_EQ(anna.Place("hello", &placed), WAYMARK_OK) << waymark_error_message();
  EXPECT_STREQ(placed.kind, "note");
  EXPECT_STREQ(placed.owner, anna.Standing().device);
  EXPECT_NEAR(placed.map_from_anchor.translation_m[0], 5, 1e-3);
  const AnchorId id(placed.anchor);
  ASSERT_TRUE(Eventually([&] { return support::FindAnchor(*ben, id).has_value(); }));
  EXPECT_EQ(support::FindAnchor(*ben, id)->payload, "hello");
  EXPECT_TRUE(anna.Hears(WAYMARK_ANCHOR_CHANGED, placed.anchor));

  // Ben moves it; Anna, who has not looked since, is told what stands.
  ASSERT_TRUE(
      ben->MoveAnchor(*support::FindAnchor(*ben, id), {Eigen::Quaterniond::Identity(), {7, 7, 2}})
          .ok());
  auto now = Sized<WaymarkAnchor>();
  const WaymarkTransform there = At(1, 1, 1);
  EXPECT_EQ(waymark_move_anchor(anna.session(), &placed, &there, &now), WAYMARK_CONFLICT);
  EXPECT_EQ(now.map_from_anchor.translation_m[0], 7);
  EXPECT_GT(now.revision, placed.revision);
  EXPECT_EQ(waymark_delete_anchor(anna.session(), &placed, nullptr), WAYMARK_CONFLICT);
  EXPECT_EQ(waymark_move_anchor(anna.session(), &now, &there, &now), WAYMARK_OK)
      << waymark_error_message();
  EXPECT_EQ(now.map_from_anchor.translation_m[0], 1);

  std::array<char, 5> payload{};
  std::size_t bytes = 0;
  EXPECT_EQ(waymark_anchor_payload(anna.session(), placed.anchor, payload.data(), 4, &bytes),
            WAYMARK_TOO_SMALL);
  EXPECT_EQ(bytes, 5u);
  EXPECT_EQ(waymark_anchor_payload(anna.session(), placed.anchor, payload.data(), 5, &bytes),
            WAYMARK_OK);
  EXPECT_EQ(std::string(payload.data(), bytes), "hello");

  std::array<WaymarkAnchor, 1> anchors{now};
  EXPECT_EQ(waymark_anchors(anna.session(), anchors.data(), 1, &bytes), WAYMARK_OK);
  EXPECT_STREQ(anchors[0].anchor, placed.anchor);
  EXPECT_EQ(waymark_delete_anchor(anna.session(), &now, &now), WAYMARK_OK);
  EXPECT_EQ(now.revision, 0u) << "nothing stands";
  EXPECT_EQ(waymark_find_anchor(anna.session(), placed.anchor, &now), WAYMARK_NOT_FOUND);
  EXPECT_TRUE(anna.Hears(WAYMARK_ANCHOR_GONE, placed.anchor));
}

TEST_F(CInterface, APrivateAnchorIsItsOwnersAlone) {
  StartServer();
  const auto ben = Join("Ben");
  DeviceOptions options = MakeDeviceOptions("Anna");
  options.owner_secret = "anna's";
  const CPhone anna(options);
  options.name = "Anna's tablet";
  const auto tablet = Join(options);
  ASSERT_TRUE(anna.Localise());
  auto placed = Sized<WaymarkAnchor>();
  ASSERT_EQ(anna.Place("hello", &placed, WAYMARK_FOR_OWNER), WAYMARK_OK) << waymark_error_message();
  EXPECT_EQ(placed.audience, WAYMARK_FOR_OWNER);
  EXPECT_STREQ(placed.owner, anna.Standing().owner);
  const AnchorId id(placed.anchor);
  EXPECT_TRUE(Eventually([&] { return support::FindAnchor(*tablet, id).has_value(); }));
  auto later = Sized<WaymarkAnchor>();
  ASSERT_EQ(anna.Place("for all", &later, WAYMARK_PUBLIC), WAYMARK_OK);
  EXPECT_EQ(later.audience, WAYMARK_PUBLIC);
  ASSERT_TRUE(
      Eventually([&] { return support::FindAnchor(*ben, AnchorId(later.anchor)).has_value(); }));
  EXPECT_FALSE(support::FindAnchor(*ben, id));
  EXPECT_EQ(anna.Place("nobody", nullptr, 7), WAYMARK_INVALID_ARGUMENT);
  EXPECT_THAT(waymark_error_message(), HasSubstr("audience"));
}

TEST_F(CInterface, ModeratorsKickAndTheKickedLearnWhy) {
  options_.open_role = Role::kModerator;
  StartServer();
  const CPhone anna(MakeDeviceOptions("Anna")), ben(MakeDeviceOptions("Ben"));
  ASSERT_EQ(anna.joined(), WAYMARK_OK) << anna.message();
  EXPECT_EQ(anna.Standing().role, WAYMARK_MODERATOR);
  EXPECT_EQ(waymark_set_capacity(anna.session(), 7), WAYMARK_OK) << waymark_error_message();
  EXPECT_EQ(waymark_set_capacity(anna.session(), -1), WAYMARK_INVALID_ARGUMENT);
  ASSERT_EQ(waymark_kick(anna.session(), ben.Standing().device, "too loud"), WAYMARK_OK)
      << waymark_error_message();
  EXPECT_TRUE(Eventually([&] { return ben.Standing().is_in == 0; }));
  EXPECT_THAT(ben.Standing().reason, HasSubstr("too loud"));
  EXPECT_TRUE(ben.Hears(WAYMARK_STANDING_CHANGED, ""));
  EXPECT_EQ(waymark_readmit(anna.session(), ben.Standing().device), WAYMARK_OK)
      << waymark_error_message();
}

TEST_F(CInterface, APhoneInCFindsItselfLeavesANoteAndLooksAround) {
  StartServer();
  const auto ben = Join("Ben");
  StandingPhone ben_phone(*ben, {6, 4, 1});
  ASSERT_TRUE(ben_phone.Localise());
  const auto picture = folder_ / "picture.grey";
  std::ofstream(picture) << std::string(64 * 48, 'm');
  const DeviceOptions options = MakeDeviceOptions("C");
  const GeoPoint place = TangentPlane(support::MapOrigin()).ToGeo(Point<Map>(3, 4, 1));
  support::Peer phone(
      {options.server, std::to_string(domain_), options.room.text(), picture.string(), "64", "48",
       fmt::format("{:.9f}", place.latitude.degrees()),
       fmt::format("{:.9f}", place.longitude.degrees())},
      C_PHONE);
  // Its camera is in the middle of the device: (0.1, 0, 0.05) from where the server believes it.
  EXPECT_THAT(phone.line(), testing::StartsWith("state 2 at 3.10 4.00 0.05"));
  EXPECT_THAT(phone.ReadLine(), testing::StartsWith("placed "));
  EXPECT_THAT(phone.ReadLine(), HasSubstr("other Ben at 6.0"));
  EXPECT_EQ(phone.AwaitEnd(), 0);
  ASSERT_TRUE(Eventually([&] { return ben->Anchors().size() == 1; }));
  EXPECT_EQ(ben->Anchors().front().payload, "hello from C");
}

TEST_F(CInterface, WhatCannotBeJoinedSaysWhy) {
  StartServer();
  const CPhone nobody(MakeDeviceOptions("Anna", "no such room!"));
  EXPECT_EQ(nobody.joined(), WAYMARK_INVALID_ARGUMENT);
  EXPECT_THAT(nobody.message(), HasSubstr("room"));
  EXPECT_EQ(nobody.session(), 0u);
}

TEST_F(CInterface, ChangesNeedNotBeWaitedFor) {
  StartServer();
  const auto ben = Join("Ben");
  const CPhone anna(MakeDeviceOptions("Anna"));
  ASSERT_EQ(anna.joined(), WAYMARK_OK) << anna.message();
  ASSERT_TRUE(anna.Localise());
  auto placement = Sized<WaymarkPlacement>();
  placement.device_from_anchor = At(2, 0, 0);
  placement.kind = "note";
  auto anchor = Sized<WaymarkAnchor>();
  ASSERT_EQ(waymark_begin_place_anchor(anna.session(), &placement, &anchor), WAYMARK_OK);
  EXPECT_EQ(anchor.is_pending, 1);
  const WaymarkTransform there = At(7, 7, 1);
  EXPECT_EQ(waymark_begin_move_anchor(anna.session(), &anchor, &there), WAYMARK_OK);
  EXPECT_EQ(waymark_find_anchor(anna.session(), anchor.anchor, &anchor), WAYMARK_OK);
  EXPECT_EQ(anchor.map_from_anchor.translation_m[0], 7);
  int ended = 0;
  EXPECT_TRUE(Eventually([&] {
    auto event = Sized<WaymarkEvent>();
    EXPECT_EQ(waymark_next_event(anna.session(), &event), WAYMARK_OK);
    if (event.kind != WAYMARK_EDIT_ENDED) return false;
    EXPECT_EQ(event.value, WAYMARK_OK);
    EXPECT_STREQ(event.id, anchor.anchor);
    return ++ended == 2;
  }));
  EXPECT_EQ(waymark_find_anchor(anna.session(), anchor.anchor, &anchor), WAYMARK_OK);
  EXPECT_EQ(anchor.is_pending, 0);
  EXPECT_TRUE(
      Eventually([&] { return support::FindAnchor(*ben, AnchorId(anchor.anchor)).has_value(); }));
  EXPECT_EQ(waymark_begin_delete_anchor(anna.session(), &anchor), WAYMARK_OK);
  EXPECT_EQ(waymark_find_anchor(anna.session(), anchor.anchor, &anchor), WAYMARK_NOT_FOUND);
  EXPECT_TRUE(Eventually([&] { return !support::FindAnchor(*ben, AnchorId(anchor.anchor)); }));
}

}  // namespace
}  // namespace waymark::session

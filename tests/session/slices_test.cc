// SPDX-License-Identifier: Apache-2.0
// A bus that is cut into slices: every room lives on one of them as on a bus of its own.
#include "session/wire/slices.h"

#include <set>

#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::Sees;
using support::StandingPhone;
using testing::HasSubstr;

// Both ends compute it, perhaps in programs of different age.
TEST(SliceOf, IsTheRoomsFnv1aHash) {
  EXPECT_EQ(wire::SliceOf(RoomId("a"), 64), 0xE40C292CU % 64);
  EXPECT_EQ(wire::SliceOf(RoomId("foobar"), 64), 0xBF9CF968U % 64);
  EXPECT_EQ(wire::SliceOf(RoomId("foobar"), 7), 0xBF9CF968U % 7);
  EXPECT_EQ(wire::SliceOf(RoomId("anywhere"), 1), 0);
}

TEST(SliceOf, SpreadsRooms) {
  std::vector<int> rooms(16);
  for (int i = 0; i < 1600; ++i) ++rooms[wire::SliceOf(RoomId(fmt::format("room-{}", i)), 16)];
  for (const int count : rooms) {
    EXPECT_GT(count, 50);
    EXPECT_LT(count, 150);
  }
}

constexpr int kSlices = 4;

class Slices : public support::SessionTest {
 protected:
  void SetUp() override {
    options_.slices = kSlices;
    StartServer();
  }

  /// Two rooms that are on different slices, neither of them the first.
  const std::string here_ = "square", there_ = "lobby";
};

TEST_F(Slices, ArePlacesApart) {
  const std::set<int> slices{0, wire::SliceOf(RoomId(here_), kSlices),
                             wire::SliceOf(RoomId(there_), kSlices)};
  ASSERT_EQ(slices.size(), 3u);
}

TEST_F(Slices, EachRoomIsAsOnABusOfItsOwn) {
  const auto anna = Join(MakeDeviceOptions("Anna", here_)),
             ben = Join(MakeDeviceOptions("Ben", here_)),
             carl = Join(MakeDeviceOptions("Carl", there_)),
             dora = Join(MakeDeviceOptions("Dora", there_));
  ASSERT_TRUE(anna && ben && carl && dora);
  StandingPhone phone(*anna, {3, 4, 1}), other(*carl, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  ASSERT_TRUE(other.Localise());
  const auto note = anna->PlaceAnchor(kAhead, "note", "here");
  const auto sign = carl->PlaceAnchor(kAhead, "note", "there");
  ASSERT_TRUE(note.ok() && sign.ok());
  const auto knows = [&](const auto& session, const auto& who, const auto& what) {
    const auto seen = support::FindOther(*session, who->id());
    return seen && seen->map_from_device && FindAnchor(*session, what->id).has_value();
  };
  EXPECT_TRUE(Eventually([&] {
    phone.Live();
    other.Live();
    return knows(ben, anna, note) && knows(dora, carl, sign);
  }));
  EXPECT_FALSE(Sees(*ben, carl->id()));
  EXPECT_FALSE(FindAnchor(*ben, sign->id).has_value());
  EXPECT_TRUE(Eventually([&] { return anna->SessionTime(StandingPhone::Now()).has_value(); }));
}

TEST_F(Slices, WhatWasPlacedIsThereForTheNextRun) {
  auto anna = Join(MakeDeviceOptions("Anna", there_));
  ASSERT_NE(anna, nullptr);
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto note = anna->PlaceAnchor(kAhead, "note", "stays");
  ASSERT_TRUE(note.ok());
  StopServer();
  StartServer();
  EXPECT_TRUE(Eventually([&] { return anna->Statistics().joins == 2; }));
  const auto ben = Join(MakeDeviceOptions("Ben", there_));
  ASSERT_NE(ben, nullptr);
  EXPECT_TRUE(Eventually([&] { return FindAnchor(*ben, note->id) && Sees(*ben, anna->id()); }));
}

TEST_F(Slices, WhoKnowsOfOneOnlyIsToldOfTheOthers) {
  options_.slices = 1;  // as the gateway and its phones are told
  gateway_.reset();
  if (support::UsesGateway()) StartGateway();
  for (const std::string& room : {here_, there_}) {
    const auto lost = DeviceSession::Join(MakeDeviceOptions("Lost", room));
    ASSERT_FALSE(lost.ok());
    EXPECT_EQ(lost.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(lost.error().message,
                HasSubstr(fmt::format("expected slice {} of {}",
                                      wire::SliceOf(RoomId(room), kSlices), kSlices)));
    EXPECT_THAT(lost.error().message, HasSubstr("--slices 4"));
  }
}

TEST_F(Slices, MoreThanThereAreAreNotWaitedForInSilence) {
  if (support::UsesGateway()) GTEST_SKIP() << "a gateway waits for the server as ever";
  DeviceOptions options = MakeDeviceOptions("Lost", "room-1");
  options.dds_slices = 64;
  options.request_timeout = std::chrono::duration<double>(1);
  ASSERT_GE(wire::SliceOf(options.room, 64), kSlices);
  const auto lost = DeviceSession::Join(options);
  ASSERT_FALSE(lost.ok());
  EXPECT_EQ(lost.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(lost.error().message, HasSubstr("of 64"));
}

TEST(SliceOptions, AreChecked) {
  ServerOptions server;
  server.slices = 0;
  EXPECT_FALSE(server.Validate().ok());
  server.slices = 65;
  EXPECT_FALSE(server.Validate().ok());
  DeviceOptions device;
  device.dds_slices = 0;
  EXPECT_FALSE(device.Validate().ok());
  GatewayOptions gateway;
  gateway.slices = 65;
  EXPECT_FALSE(gateway.Validate().ok());
}

}  // namespace
}  // namespace waymark::session

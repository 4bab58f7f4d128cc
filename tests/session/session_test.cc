// SPDX-License-Identifier: Apache-2.0
// Whole sessions over DDS on loopback.
#include <atomic>

#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::FindAnchor;
using support::FindOther;
using support::kAhead;
using support::Sees;
using support::StandingPhone;

using Session = support::SessionTest;

TEST_F(Session, DevicesSeeEachOtherComeMoveAndGo) {
  StartServer();
  const auto anna = Join("Anna"), ben = Join("Ben"), cleo = Join("Cleo");
  EXPECT_TRUE(Eventually([&] {
    return Sees(*anna, ben->id()) && Sees(*anna, cleo->id()) && Sees(*ben, anna->id()) &&
           Sees(*ben, cleo->id()) && Sees(*cleo, anna->id()) && Sees(*cleo, ben->id());
  }));
  EXPECT_EQ(FindOther(*anna, ben->id())->name, "Ben");

  StandingPhone anna_phone(*anna, {3, 4, 1}), ben_phone(*ben, {-7, 2, 1.5});
  ASSERT_TRUE(anna_phone.Localise());
  ASSERT_TRUE(ben_phone.Localise());
  EXPECT_LT((anna->Pose().map_from_device->translation() - Eigen::Vector3d(3, 4, 1)).norm(), 1e-3);
  const auto is_at = [](const DeviceSession& viewer, const DeviceId& id,
                        const Eigen::Vector3d& position) {
    const auto other = FindOther(viewer, id);
    return other && other->map_from_device && other->epoch == 1 &&
           (other->map_from_device->translation() - position).norm() < 1e-3;
  };
  EXPECT_TRUE(Eventually([&] {
    return is_at(*cleo, anna->id(), {3, 4, 1}) && is_at(*cleo, ben->id(), {-7, 2, 1.5}) &&
           is_at(*ben, anna->id(), {3, 4, 1});
  }));
  ben_phone.MoveTo({-6, 2, 1.5});
  EXPECT_TRUE(Eventually([&] {
    ben_phone.Live();
    return is_at(*anna, ben->id(), {-6, 2, 1.5});
  }));
  // A wrong clock offset would make the age grow without bound or negative by far.
  EXPECT_LT(std::abs(FindOther(*anna, ben->id())->age.count()), 30);

  cleo->Leave();
  EXPECT_TRUE(Eventually([&] { return !Sees(*anna, cleo->id()) && !Sees(*ben, cleo->id()); }));
  EXPECT_TRUE(Sees(*anna, ben->id()));
}

/// Whether the clock can be read, or only its stamps be seen.
class SessionClock : public Session, public testing::WithParamInterface<bool> {};

TEST_P(SessionClock, SetByAnHourIsNoticedAndHarmless) {
  StartServer();
  DeviceOptions options = MakeDeviceOptions("Anna");
  std::atomic<std::int64_t> set_ns = 0;
  if (GetParam()) {
    options.clock = [&] { return StandingPhone::Now() + std::chrono::nanoseconds(set_ns); };
  }
  const auto anna = Join(options), ben = Join("Ben");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto session_ahead = [&] {  // of a clock that nobody sets
    return *anna->SessionTime(phone.OwnNow()) - ServerTime(StandingPhone::Now().time_since_epoch());
  };
  const auto before = session_ahead();
  int jumps = 0;
  for (const std::chrono::hours by : {std::chrono::hours(1), std::chrono::hours(-1)}) {
    phone.SetClock(by);
    set_ns += std::chrono::nanoseconds(by).count();
    phone.Live();
    EXPECT_EQ(anna->Statistics().clock_jumps, ++jumps);
    EXPECT_LT(std::abs(Seconds(session_ahead() - before)), 1) << by.count();
    EXPECT_EQ(anna->Pose().state, localiser::AlignmentState::kFixed);
    const int fixes = anna->Statistics().fixes;
    EXPECT_TRUE(Eventually([&] {
      phone.Live();
      return anna->Statistics().fixes > fixes + 1;
    }));
    EXPECT_EQ(anna->Pose().state, localiser::AlignmentState::kFixed);
    EXPECT_TRUE(Eventually([&] {
      phone.Live();
      const auto seen = FindOther(*ben, anna->id());
      return seen && std::abs(seen->age.count()) < 5;
    }));
  }
}

INSTANTIATE_TEST_SUITE_P(Session, SessionClock, testing::Bool());

TEST_F(Session, RoomsDoNotHearEachOther) {
  StartServer();
  const auto anna = Join("Anna"), ben = Join("Ben");
  const auto other_room = Join(MakeDeviceOptions("Dora", "elsewhere"));
  StandingPhone anna_phone(*anna, {3, 4, 1});
  ASSERT_TRUE(anna_phone.Localise());
  ASSERT_TRUE(anna->PlaceAnchor(kAhead, "note", "hello").ok());
  EXPECT_TRUE(Eventually([&] { return ben->Anchors().size() == 1 && Sees(*ben, anna->id()); }));
  EXPECT_TRUE(Eventually([&] { return other_room->HasSnapshot(); }));
  EXPECT_TRUE(other_room->Others().empty());
  EXPECT_TRUE(other_room->Anchors().empty());
}

TEST_F(Session, AnchorsAreSeenByAllWhenCreatedMovedAndDeleted) {
  StartServer();
  const auto anna = Join("Anna"), ben = Join("Ben"), cleo = Join("Cleo");
  StandingPhone anna_phone(*anna, {3, 4, 1});
  EXPECT_EQ(anna->PlaceAnchor(kAhead, "note", "hello").error().code, ErrorCode::kUnavailable);
  ASSERT_TRUE(anna_phone.Localise());

  const auto placed = anna->PlaceAnchor(kAhead, "note", "hello");
  ASSERT_TRUE(placed.ok()) << ToString(placed.error());
  EXPECT_EQ(placed->owner, anna->id());
  EXPECT_TRUE(placed->is_supported);
  EXPECT_LT((placed->map_from_anchor.translation() - Eigen::Vector3d(5, 4, 1)).norm(), 1e-3);
  EXPECT_TRUE(FindAnchor(*anna, placed->id)) << "one's own change is seen at once";
  EXPECT_TRUE(
      Eventually([&] { return FindAnchor(*ben, placed->id) && FindAnchor(*cleo, placed->id); }));
  EXPECT_EQ(FindAnchor(*cleo, placed->id)->payload, "hello");

  const Transform<Map, Anchor> there(Eigen::Quaterniond::Identity(), {6, 6, 2});
  const auto moved = ben->MoveAnchor(*placed, there);
  ASSERT_TRUE(moved.ok()) << ToString(moved.error());
  EXPECT_GT(moved->revision, placed->revision);
  EXPECT_EQ(moved->owner, anna->id());
  for (const auto* session : {&anna, &ben, &cleo}) {
    EXPECT_TRUE(Eventually([&] {
      const auto anchor = FindAnchor(**session, placed->id);
      return anchor && anchor->map_from_anchor.translation() == there.translation();
    }));
  }

  // Cleo still holds the first revision: told so, and nothing changes.
  const auto lost = cleo->MoveAnchor(*placed, {Eigen::Quaterniond::Identity(), {0, 0, 0}});
  ASSERT_FALSE(lost.ok());
  EXPECT_EQ(lost.error().code, ErrorCode::kConflict);
  EXPECT_EQ(cleo->DeleteAnchor(*placed).error().code, ErrorCode::kConflict);

  EXPECT_TRUE(cleo->DeleteAnchor(*moved).ok());
  for (const auto* session : {&anna, &ben, &cleo}) {
    EXPECT_TRUE(Eventually([&] { return !FindAnchor(**session, placed->id); }));
  }
  EXPECT_EQ(anna->DeleteAnchor(*moved).error().code, ErrorCode::kNotFound);
}

TEST_F(Session, ALateJoinerGetsTheWholeRoom) {
  StartServer();
  constexpr std::size_t kAnchors = 100;
  const auto anna = Join("Anna");
  StandingPhone anna_phone(*anna, {3, 4, 1});
  ASSERT_TRUE(anna_phone.Localise());
  std::vector<SharedAnchor> placed;
  for (std::size_t i = 0; i < kAnchors; ++i) {
    const auto anchor = anna->PlaceAnchor(kAhead, "note", std::to_string(i));
    ASSERT_TRUE(anchor.ok()) << ToString(anchor.error());
    placed.push_back(*anchor);
  }
  for (std::size_t i = 0; i < 10; ++i) ASSERT_TRUE(anna->DeleteAnchor(placed[i]).ok());

  const auto late = Join("Late");
  ASSERT_TRUE(Eventually([&] { return late->HasSnapshot(); }));
  EXPECT_EQ(late->Anchors().size(), kAnchors - 10);
  EXPECT_FALSE(FindAnchor(*late, placed[0].id));
  for (std::size_t i = 10; i < kAnchors; ++i) {
    const auto anchor = FindAnchor(*late, placed[i].id);
    ASSERT_TRUE(anchor);
    EXPECT_EQ(anchor->payload, std::to_string(i));
    EXPECT_EQ(anchor->revision, placed[i].revision);
  }
  EXPECT_TRUE(Eventually([&] { return Sees(*late, anna->id()); }));
  EXPECT_TRUE(Eventually([&] {
    anna_phone.Live();
    return FindOther(*late, anna->id())->map_from_device.has_value();
  }));
}

TEST_F(Session, AnchorsAreCarriedToANewRelease) {
  StartServer(support::MakeRelease(1));
  const auto anna = Join("Anna");
  StandingPhone anna_phone(*anna, {3, 4, 1});
  ASSERT_TRUE(anna_phone.Localise());
  const auto placed = anna->PlaceAnchor(kAhead, "note", "hello");
  ASSERT_TRUE(placed.ok());
  StopServer();

  StartServer(support::MakeRelease(2));  // its submap lies 5 m further east
  ASSERT_TRUE(Eventually([&] { return anna->DescribeMap().epoch == 2 && anna->HasSnapshot(); }));
  const auto carried = FindAnchor(*anna, placed->id);
  ASSERT_TRUE(carried);
  EXPECT_EQ(carried->epoch, 2u);
  EXPECT_LT((carried->map_from_anchor.translation() - placed->map_from_anchor.translation() -
             Eigen::Vector3d(5, 0, 0))
                .norm(),
            1e-9);
  EXPECT_EQ(anna->MoveAnchor(*placed, placed->map_from_anchor).error().code, ErrorCode::kConflict)
      << "a pose in the old epoch must not be taken for one in the new";
}

TEST_F(Session, ASecondServerOnTheDomainIsRefused) {
  StartServer();
  const auto second = Server::Start(options_, MakeParts());
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kConflict);
}

TEST_F(Session, ARoomNameThatCouldMeanMoreIsRefused) {
  StartServer();
  for (const char* room : {"", "a.b", "*", "../x", "sp ace", "'; DROP TABLE anchors; --"}) {
    const auto session = DeviceSession::Join(MakeDeviceOptions("Anna", room));
    ASSERT_FALSE(session.ok()) << room;
    EXPECT_EQ(session.error().code, ErrorCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace waymark::session

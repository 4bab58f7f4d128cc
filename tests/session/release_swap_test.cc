// SPDX-License-Identifier: Apache-2.0
// Another release goes live under a session: nothing moves for those who are there.
#include <algorithm>
#include <array>
#include <cmath>

#include "session/server/attachments.h"
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::StandingPhone;

class ReleaseSwap : public support::SessionTest {
 protected:
  void SwapTo(std::uint64_t epoch) {
    const mapping::Release release = support::MakeRelease(epoch);
    server_->Swap({release, support::BelievePrior(release)});
  }

  /// Where the phone shows the anchor, in its own axes; asked again when the release changed
  /// between the questions.
  static Rigid3 Look(const DeviceSession& session, const AnchorId& id) {
    while (true) {
      const DevicePose pose = session.Pose();
      const auto anchor = FindAnchor(session, id);
      if (session.Pose().epoch != pose.epoch) continue;
      EXPECT_TRUE(pose.map_from_device && anchor);
      EXPECT_EQ(anchor->epoch, pose.epoch) << "pose and anchors change together";
      return pose.map_from_device->rigid().Inverse() * anchor->map_from_anchor.rigid();
    }
  }
};

TEST_F(ReleaseSwap, NothingMovesForThoseWhoAreThere) {
  StartServer(support::MakeRelease(1));
  const auto anna = Join("Anna"), ben = Join("Ben");
  StandingPhone anna_phone(*anna, {3, 4, 1}), ben_phone(*ben, {6, 1, 1});
  ASSERT_TRUE(anna_phone.Localise() && ben_phone.Localise());
  const auto placed = anna->PlaceAnchor(kAhead, "note", "hello");
  ASSERT_TRUE(placed.ok()) << ToString(placed.error());
  ASSERT_TRUE(Eventually([&] { return FindAnchor(*ben, placed->id).has_value(); }));
  const std::array sessions{anna.get(), ben.get()};
  const std::array seen{Look(*anna, placed->id), Look(*ben, placed->id)};

  for (const std::uint64_t epoch : {2u, 3u, 1u}) {  // the last is a rollback
    SwapTo(epoch);
    const auto have_gone_over = [&] {
      for (std::size_t i = 0; i < sessions.size(); ++i) {
        const Rigid3 now = Look(*sessions[i], placed->id);
        EXPECT_LT(Difference(seen[i], now).norm(), 1e-6) << "epoch " << epoch;
        EXPECT_EQ(sessions[i]->Pose().state, localiser::AlignmentState::kFixed);
      }
      return anna->DescribeMap().epoch == epoch && ben->DescribeMap().epoch == epoch;
    };
    ASSERT_TRUE(Eventually(have_gone_over));
    const double east_m = 5.0 * (static_cast<double>(epoch) - 1);  // the submap went there
    const auto anchor = FindAnchor(*ben, placed->id);
    EXPECT_LT((anchor->map_from_anchor.translation() - placed->map_from_anchor.translation() -
               Eigen::Vector3d(east_m, 0, 0))
                  .norm(),
              1e-9);
    EXPECT_TRUE(anchor->is_supported);
  }
  EXPECT_EQ(anna->Statistics().map_changes, 3);
  EXPECT_EQ(anna->Statistics().joins, 1) << "nobody was cut off";
  EXPECT_EQ(StopServer().swaps, 3u);
}

TEST_F(ReleaseSwap, IsSurvivedByBadLinks) {
  options_.transmit_loss_per_mille = device_loss_per_mille_ = 150;
  StartServer(support::MakeRelease(1));
  const auto anna = Join("Anna");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto placed = anna->PlaceAnchor(kAhead, "note", "hello");
  ASSERT_TRUE(placed.ok()) << ToString(placed.error());
  const Rigid3 seen = Look(*anna, placed->id);
  SwapTo(2);
  ASSERT_TRUE(Eventually([&] {
    EXPECT_LT(Difference(seen, Look(*anna, placed->id)).norm(), 1e-6);
    return anna->DescribeMap().epoch == 2;
  }));
}

TEST_F(ReleaseSwap, WhatWasSaidJustBeforeIsUnderstood) {
  StartServer(support::MakeRelease(1));
  const auto anna = Join("Anna");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto placed = anna->PlaceAnchor(kAhead, "note", "hello");
  ASSERT_TRUE(placed.ok());
  SwapTo(2);
  ASSERT_TRUE(Eventually([&] { return anna->DescribeMap().epoch == 2; }));
  // The application still thinks in the frame of the release before.
  const Transform<Map, Anchor> there(Eigen::Quaterniond::Identity(), {6, 6, 2});
  const auto moved = anna->MoveAnchor(*placed, there);
  ASSERT_TRUE(moved.ok()) << ToString(moved.error());
  EXPECT_EQ(moved->epoch, 2u);
  EXPECT_LT((moved->map_from_anchor.translation() - Eigen::Vector3d(11, 6, 2)).norm(), 1e-9);
}

TEST_F(ReleaseSwap, WhoComesLaterStandsInTheNewRelease) {
  StartServer(support::MakeRelease(1));
  const auto anna = Join("Anna");
  StandingPhone anna_phone(*anna, {3, 4, 1});
  ASSERT_TRUE(anna_phone.Localise());
  const auto placed = anna->PlaceAnchor(kAhead, "note", "hello");
  ASSERT_TRUE(placed.ok());
  SwapTo(2);
  ASSERT_TRUE(Eventually([&] { return anna->DescribeMap().epoch == 2; }));
  const auto late = Join("Late");
  EXPECT_EQ(late->DescribeMap().epoch, 2u);
  ASSERT_TRUE(Eventually([&] { return late->HasSnapshot(); }));
  EXPECT_EQ(FindAnchor(*late, placed->id)->epoch, 2u);
  StandingPhone late_phone(*late, {6, 1, 1});
  ASSERT_TRUE(late_phone.Localise());
  EXPECT_TRUE(Eventually([&] {
    anna_phone.Live();
    for (const OtherDevice& other : late->Others()) {
      if (other.id == anna->id() && other.map_from_device) return other.epoch == 2;
    }
    return false;
  })) << "poses are shared again at once";
  EXPECT_EQ(late->Statistics().map_changes, 0);
}

/// As MakeRelease, with three submaps of which each next release has one anew.
mapping::Release MakeChained(std::uint64_t epoch) {
  mapping::Release release = support::MakeRelease(epoch);
  const mapping::ReleasedSubmap like = release.submaps.front();
  release.submaps.clear();
  for (std::uint64_t number = epoch; number < epoch + 3; ++number) {
    release.submaps.push_back(like);
    release.submaps.back().id = SubmapId(fmt::format("{:032x}", number));
  }
  return release;
}

TEST_F(ReleaseSwap, AnAnchorOutlivesAllSubmapsThatItBeganWith) {
  StartServer(MakeChained(1));
  const auto anna = Join("Anna");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto placed = anna->PlaceAnchor(kAhead, "note", "hello");
  ASSERT_TRUE(placed.ok()) << ToString(placed.error());
  std::uint64_t revision = placed->revision;
  for (std::uint64_t epoch = 2; epoch <= 6; ++epoch) {
    const mapping::Release release = MakeChained(epoch);
    server_->Swap({release, support::BelievePrior(release)});
    ASSERT_TRUE(Eventually([&] {
      const auto anchor = FindAnchor(*anna, placed->id);
      return anchor && anchor->epoch == epoch && anchor->revision > revision;
    })) << "it is attached anew in epoch "
        << epoch;
    const auto anchor = FindAnchor(*anna, placed->id);
    revision = anchor->revision;
    EXPECT_TRUE(anchor->is_supported);
    const double east_m = 5.0 * (static_cast<double>(epoch) - 1);
    EXPECT_LT((anchor->map_from_anchor.translation() - placed->map_from_anchor.translation() -
               Eigen::Vector3d(east_m, 0, 0))
                  .norm(),
              1e-6);
  }
  SharedAnchor known = *FindAnchor(*anna, placed->id);
  known.revision = revision - 1;  // what the application read before it was attached anew
  const auto moved = anna->MoveAnchor(known, known.map_from_anchor);
  EXPECT_TRUE(moved.ok()) << ToString(moved.error());
}

/// As MakeRelease, in a map of more submaps than phones can be told of.
mapping::Release MakeLarge(std::uint64_t epoch) {
  mapping::Release release = support::MakeRelease(epoch);
  mapping::ReleasedSubmap far = release.submaps.front();
  far.centre = Point<Map>(5000, 0, 0);
  for (std::size_t i = 0; i < kMaxPlacements; ++i) {
    far.id = SubmapId(fmt::format("ff{:030x}", i));
    release.submaps.push_back(far);
  }
  return release;
}

class LargeRoom : public ReleaseSwap {
 protected:
  static constexpr int kAnchors = 1000;  // four portions

  /// Anchors about the origin, one of which Anna looks at.
  void StartWithMany() {
    const mapping::Release release = MakeLarge(1);
    const TangentPlane map_plane(support::MapOrigin());
    std::vector<content::AnchorRecord> records;
    for (std::uint64_t i = 0; i < kAnchors; ++i) {
      content::AnchorRecord record{.id = AnchorId(FormatUuid(UuidFromBits(7, i))),
                                   .room = RoomId("square")};
      record.owner = FormatUuid(UuidFromBits(8, 0));
      record.map_from_anchor = {Eigen::Quaterniond::Identity(),
                                {0.1 * static_cast<double>(i), 2, 1}};
      record.attachments = AttachToSubmaps(record.map_from_anchor, {}, release);
      record.place = map_plane.ToGeo(Point<Map>(record.map_from_anchor.translation()));
      record.kind = "note";
      records.push_back(std::move(record));
    }
    auto store = content::OpenSqliteStore(StorePath());
    ASSERT_TRUE(store.ok());
    for (const auto& created : (*store)->CreateMany(records)) ASSERT_TRUE(created.ok());
    store->reset();
    StartServer(release);
    first_ = records.front().id;
    last_ = records.back().id;
  }
  void SwapToLarge(std::uint64_t epoch) {
    const mapping::Release release = MakeLarge(epoch);
    server_->Swap({release, support::BelievePrior(release)});
  }
  static bool HasAll(const DeviceSession& session, std::uint64_t epoch) {
    const auto anchors = session.Anchors();
    return session.HasSnapshot() && anchors.size() == kAnchors &&
           std::ranges::all_of(anchors, [&](const auto& one) { return one.epoch == epoch; });
  }

  AnchorId first_{""}, last_{""};
};

TEST_F(LargeRoom, GoesOverUnderThoseWhoAreThereAndThoseWhoCome) {
  StartWithMany();
  const auto anna = Join("Anna");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  ASSERT_TRUE(Eventually([&] { return HasAll(*anna, 1); }));
  const std::array seen{Look(*anna, first_), Look(*anna, last_)};
  const auto look = [&] {
    EXPECT_LT(Difference(seen[0], Look(*anna, first_)).norm(), 1e-6);
    EXPECT_LT(Difference(seen[1], Look(*anna, last_)).norm(), 1e-6);
  };
  SwapToLarge(2);
  SwapToLarge(3);
  const auto ben = Join("Ben");
  ASSERT_TRUE(Eventually([&] {
    look();
    return HasAll(*anna, 3);
  }));
  ASSERT_TRUE(Eventually([&] { return HasAll(*ben, 3); }));
  EXPECT_EQ(ben->DescribeMap().epoch, 3u);
  SwapToLarge(2);
  SwapToLarge(3);
  ASSERT_TRUE(Eventually([&] {
    look();
    return HasAll(*anna, 3);
  }));
  EXPECT_EQ(anna->Statistics().joins, 1);
}

TEST_F(LargeRoom, WhoWalksOnTheWayKnowsAfterwardsWhatIsNear) {
  StartWithMany();
  DeviceOptions options = MakeDeviceOptions("Anna");
  options.anchor_radius_m = 20;
  const auto anna = Join(options);
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  ASSERT_TRUE(Eventually([&] { return anna->HasSnapshot(); }));
  SwapToLarge(2);
  phone.MoveTo({60, 4, 1});
  EXPECT_TRUE(Eventually([&] {
    phone.Live();
    const auto anchors = anna->Anchors();
    return anna->DescribeMap().epoch == 2 && anna->HasSnapshot() && anchors.size() > 100 &&
           std::ranges::all_of(anchors, [&](const auto& one) {
             return one.epoch == 2 && std::abs(one.map_from_anchor.translation().x() - 60) < 25;
           });
  }));
}

TEST_F(LargeRoom, OutlivesAServerThatEndsOnTheWay) {
  StartWithMany();
  const auto anna = Join("Anna");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  ASSERT_TRUE(Eventually([&] { return HasAll(*anna, 1); }));
  const Rigid3 seen = Look(*anna, last_);
  const Eigen::Vector3d before = FindAnchor(*anna, last_)->map_from_anchor.translation();
  SwapToLarge(2);
  StopServer();
  EXPECT_LT(Difference(seen, Look(*anna, last_)).norm(), 1e-6);
  StartServer(MakeLarge(2));
  ASSERT_TRUE(Eventually([&] { return HasAll(*anna, 2); }));
  const Eigen::Vector3d after = FindAnchor(*anna, last_)->map_from_anchor.translation();
  EXPECT_LT((after - before - Eigen::Vector3d(5, 0, 0)).norm(), 1e-9) << "where its submap went";
}

}  // namespace
}  // namespace waymark::session

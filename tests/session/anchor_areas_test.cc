// SPDX-License-Identifier: Apache-2.0
// A device that says how far it looks knows the anchors so near to it and no others, over DDS and
// through a gateway.
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::MakeRelease;
using support::StandingPhone;

class AnchorAreas : public support::SessionTest {
 protected:
  static constexpr double kRadius_m = 60;
  const Eigen::Vector3d here_{3, 4, 1}, far_{400, 4, 1};

  DeviceOptions Near(const std::string& name) const {
    DeviceOptions options = MakeDeviceOptions(name);
    options.anchor_radius_m = kRadius_m;
    return options;
  }
  /// Ben knows the whole room and places an anchor here and one far away.
  void StartWithTwoAnchors() {
    StartServer();
    ben_ = Join("Ben");
    ASSERT_NE(ben_, nullptr);
    near_ = PlaceAt(here_);
    there_ = PlaceAt(far_);
  }
  SharedAnchor PlaceAt(const Eigen::Vector3d& position) {
    StandingPhone phone(*ben_, position);
    EXPECT_TRUE(phone.Localise());
    EXPECT_TRUE(Eventually([&] {
      phone.Live();
      const auto pose = ben_->Pose().map_from_device;
      return pose && (pose->translation() - position).norm() < 0.1;
    }));
    const auto placed = ben_->PlaceAnchor(kAhead, "note", "hello");
    EXPECT_TRUE(placed) << ToString(placed.error());
    return *placed;
  }
  /// Whether it comes to know these and no others.
  static bool Knows(DeviceSession& phone, std::vector<AnchorId> expected,
                    StandingPhone* living = nullptr) {
    std::ranges::sort(expected);
    return Eventually([&] {
      if (living != nullptr) living->Live();
      std::vector<AnchorId> known;
      for (const SharedAnchor& anchor : phone.Anchors()) known.push_back(anchor.id);
      std::ranges::sort(known);
      return phone.HasSnapshot() && known == expected;
    });
  }

  std::unique_ptr<DeviceSession> ben_;
  std::optional<SharedAnchor> near_, there_;
};

TEST_F(AnchorAreas, WhoStandsHereKnowsWhatIsHereAndWhoWalksWhatIsThere) {
  StartWithTwoAnchors();
  const auto anna = Join(Near("Anna"));
  StandingPhone phone(*anna, here_);
  ASSERT_TRUE(phone.Localise());
  EXPECT_TRUE(Knows(*anna, {near_->id}));
  phone.MoveTo(far_);
  EXPECT_TRUE(Knows(*anna, {there_->id}, &phone));
  phone.MoveTo(here_);
  EXPECT_TRUE(Knows(*anna, {near_->id}, &phone)) << "and back";
}

TEST_F(AnchorAreas, AreKnownBeforeThePhoneIsLocalised) {
  StartWithTwoAnchors();
  DeviceOptions options = Near("Anna");
  options.about = TangentPlane(support::MapOrigin()).ToGeo(Point<Map>(far_));
  const auto anna = Join(options);
  EXPECT_TRUE(Knows(*anna, {there_->id}));
  EXPECT_FALSE(anna->Pose().map_from_device);
}

TEST_F(AnchorAreas, ChangesNearbyAreTold) {
  StartWithTwoAnchors();
  const auto anna = Join(Near("Anna"));
  ASSERT_TRUE(StandingPhone(*anna, here_).Localise());
  ASSERT_TRUE(Knows(*anna, {near_->id}));

  const Transform<Map, Anchor> beside(Eigen::Quaterniond::Identity(), {10, 4, 1});
  const auto brought = ben_->MoveAnchor(*there_, beside);
  ASSERT_TRUE(brought.ok()) << ToString(brought.error());
  EXPECT_TRUE(Knows(*anna, {near_->id, there_->id})) << "comes in";
  ASSERT_TRUE(ben_->DeleteAnchor(*near_).ok());
  EXPECT_TRUE(Knows(*anna, {there_->id})) << "is deleted";
  const Transform<Map, Anchor> away(Eigen::Quaterniond::Identity(), far_);
  ASSERT_TRUE(ben_->MoveAnchor(*brought, away).ok());
  EXPECT_TRUE(Knows(*anna, {})) << "goes out";
  const auto own = anna->PlaceAnchor(kAhead, "note", "mine");
  ASSERT_TRUE(own.ok());
  EXPECT_TRUE(Knows(*anna, {own->id}));
}

TEST_F(AnchorAreas, ARoomThatHoldsTooManyIsJoinedWithAnArea) {
  options_.state.max_told_anchors = 1;
  StartWithTwoAnchors();
  const auto refused = DeviceSession::Join(MakeDeviceOptions("Clara"));
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, testing::HasSubstr("holds 2 anchors"));
  const auto anna = Join(Near("Anna"));
  ASSERT_TRUE(StandingPhone(*anna, here_).Localise());
  EXPECT_TRUE(Knows(*anna, {near_->id}));
}

TEST_F(AnchorAreas, ARoomThatIsReadInPartsIsKnownWhole) {
  constexpr int kAnchors = 1234;
  {
    auto store = content::OpenSqliteStore(StorePath());
    ASSERT_TRUE(store.ok());
    std::vector<content::AnchorRecord> records;
    for (int i = 0; i < kAnchors; ++i) {
      content::AnchorRecord& record = records.emplace_back(content::AnchorRecord{
          .id = AnchorId(FormatUuid(UuidFromBits(3, static_cast<std::uint64_t>(i)))),
          .room = RoomId("square")});
      record.owner = "city " + std::to_string(i / 100);  // one may not write so much at once
      record.map_from_anchor = {Eigen::Quaterniond::Identity(), {static_cast<double>(i), 0, 0}};
      record.place =
          TangentPlane(support::MapOrigin()).ToGeo(Point<Map>(static_cast<double>(i), 0, 0));
    }
    for (const content::AnchorRecord& record : records) ASSERT_TRUE((*store)->Create(record).ok());
  }
  StartServer();
  const auto ben = Join("Ben");
  EXPECT_TRUE(Eventually([&] { return ben->HasSnapshot(); }));
  EXPECT_EQ(ben->Anchors().size(), kAnchors);
  DeviceOptions options = Near("Anna");
  options.about = TangentPlane(support::MapOrigin()).ToGeo(Point<Map>(600.5, 0, 0));
  const auto anna = Join(options);
  EXPECT_TRUE(Eventually([&] { return anna->HasSnapshot(); }));
  EXPECT_EQ(anna->Anchors().size(), 2 * kRadius_m);
}

TEST_F(AnchorAreas, LossesOnlyDelay) {
  options_.transmit_loss_per_mille = device_loss_per_mille_ = 150;
  StartWithTwoAnchors();
  const auto anna = Join(Near("Anna"));
  StandingPhone phone(*anna, here_);
  ASSERT_TRUE(phone.Localise());
  EXPECT_TRUE(Knows(*anna, {near_->id}, &phone));
  std::vector<AnchorId> near{near_->id};
  for (int i = 0; i < 10; ++i) near.push_back(PlaceAt(here_).id);
  EXPECT_TRUE(Knows(*anna, near, &phone));
}

TEST_F(AnchorAreas, SurviveAServerThatIsRestarted) {
  StartWithTwoAnchors();
  const auto anna = Join(Near("Anna"));
  StandingPhone phone(*anna, here_);
  ASSERT_TRUE(phone.Localise());
  ASSERT_TRUE(Knows(*anna, {near_->id}));
  StopServer();
  {
    auto store = content::OpenSqliteStore(StorePath());
    ASSERT_TRUE(store.ok());
    ASSERT_TRUE((*store)->Delete(RoomId("square"), near_->id, near_->revision).ok());
  }
  StartServer();
  EXPECT_TRUE(Knows(*anna, {}, &phone)) << "what went meanwhile has gone";
  const SharedAnchor later = PlaceAt(here_);
  EXPECT_TRUE(Knows(*anna, {later.id}, &phone));
}

TEST_F(AnchorAreas, GoOverToAnotherRelease) {
  StartWithTwoAnchors();
  const auto anna = Join(Near("Anna"));
  StandingPhone phone(*anna, here_);
  ASSERT_TRUE(phone.Localise());
  ASSERT_TRUE(Knows(*anna, {near_->id}));
  const Eigen::Vector3d before = FindAnchor(*anna, near_->id)->map_from_anchor.translation();
  const mapping::Release next = MakeRelease(2);
  server_->Swap({next, support::BelievePrior(next)});
  EXPECT_TRUE(Eventually([&] { return anna->DescribeMap().epoch == 2; }));
  EXPECT_TRUE(Eventually([&] {
    const auto carried = FindAnchor(*anna, near_->id);
    return carried && carried->epoch == 2 && anna->HasSnapshot();
  }));
  const Eigen::Vector3d after = FindAnchor(*anna, near_->id)->map_from_anchor.translation();
  EXPECT_NEAR((after - before).norm(), 5, 0.1) << "as its submap";
}

}  // namespace
}  // namespace waymark::session

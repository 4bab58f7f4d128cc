// SPDX-License-Identifier: Apache-2.0
// Private anchors reach the phones of their owner and nobody else, over DDS and through a gateway.
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using content::AnchorVisibility;
using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::MakeRelease;
using support::StandingPhone;

class PrivateAnchors : public support::SessionTest {
 protected:
  static constexpr const char* kAnnasSecret = "anna's, 7c1e90a4";

  DeviceOptions PhoneOf(const std::string& secret, const std::string& name) const {
    DeviceOptions options = MakeDeviceOptions(name);
    options.owner_secret = secret;
    return options;
  }
  void StartWithAnnaTwiceAndBen() {
    StartServer();
    anna_ = Join(PhoneOf(kAnnasSecret, "Anna"));
    annas_other_ = Join(PhoneOf(kAnnasSecret, "Anna's tablet"));
    ben_ = Join("Ben");
    ASSERT_TRUE(anna_ && annas_other_ && ben_);
    ASSERT_TRUE(StandingPhone(*anna_, {3, 4, 1}).Localise());
  }
  static SharedAnchor Place(DeviceSession& phone, AnchorVisibility audience) {
    const auto placed = phone.PlaceAnchor(kAhead, "note", "hello", audience);
    EXPECT_TRUE(placed) << ToString(placed.error());
    return *placed;
  }
  static bool Gets(const DeviceSession& phone, const AnchorId& id) {
    return Eventually([&] { return FindAnchor(phone, id).has_value(); });
  }
  static bool Loses(const DeviceSession& phone, const AnchorId& id) {
    return Eventually([&] { return !FindAnchor(phone, id); });
  }
  /// Whether a phone does not have it even when all that was written before has come.
  bool HasNot(const DeviceSession& phone, const AnchorId& id) {
    const SharedAnchor later = Place(*anna_, AnchorVisibility::kRoom);
    return Gets(phone, later.id) && Eventually([&] { return phone.HasSnapshot(); }) &&
           !FindAnchor(phone, id);
  }

  std::unique_ptr<DeviceSession> anna_, annas_other_, ben_;
};

TEST_F(PrivateAnchors, AreSeenOnAllPhonesOfTheirOwnerAndOnNoOther) {
  StartWithAnnaTwiceAndBen();
  const SharedAnchor secret = Place(*anna_, AnchorVisibility::kPrivate);
  EXPECT_EQ(secret.audience, AnchorVisibility::kPrivate);
  EXPECT_EQ(secret.owner.text(), anna_->Standing().owner);
  ASSERT_TRUE(Gets(*annas_other_, secret.id));
  EXPECT_EQ(FindAnchor(*annas_other_, secret.id)->payload, "hello");
  EXPECT_TRUE(HasNot(*ben_, secret.id));

  const Transform<Map, Anchor> there(Eigen::Quaterniond::Identity(), {6, 6, 2});
  const auto moved = annas_other_->MoveAnchor(*FindAnchor(*annas_other_, secret.id), there);
  ASSERT_TRUE(moved) << ToString(moved.error());
  EXPECT_TRUE(
      Eventually([&] { return FindAnchor(*anna_, secret.id)->revision == moved->revision; }));
  EXPECT_FALSE(ben_->MoveAnchor(*moved, there)) << "Ben knows its id from elsewhere";
  EXPECT_EQ(ben_->DeleteAnchor(*moved).error().code, ErrorCode::kNotFound);

  ASSERT_TRUE(anna_->DeleteAnchor(*FindAnchor(*anna_, secret.id)));
  EXPECT_TRUE(Loses(*annas_other_, secret.id));
  EXPECT_TRUE(Eventually([&] { return annas_other_->HasSnapshot(); }));
}

TEST_F(PrivateAnchors, WaitForTheirOwnerToComeBack) {
  StartWithAnnaTwiceAndBen();
  const SharedAnchor kept = Place(*anna_, AnchorVisibility::kPrivate);
  const SharedAnchor ended = Place(*anna_, AnchorVisibility::kPrivate);
  ASSERT_TRUE(Gets(*annas_other_, ended.id));
  const DeviceId id = annas_other_->id();
  annas_other_.reset();
  ASSERT_TRUE(anna_->DeleteAnchor(ended));
  DeviceOptions again = PhoneOf(kAnnasSecret, "Anna's tablet");
  again.id = id;
  annas_other_ = Join(again);
  ASSERT_NE(annas_other_, nullptr);
  ASSERT_TRUE(Eventually([&] { return annas_other_->HasSnapshot(); }));
  EXPECT_TRUE(FindAnchor(*annas_other_, kept.id));
  EXPECT_FALSE(FindAnchor(*annas_other_, ended.id));

  const auto late = Join("Late");
  ASSERT_TRUE(Eventually([&] { return late->HasSnapshot(); }));
  EXPECT_FALSE(FindAnchor(*late, kept.id));
}

TEST_F(PrivateAnchors, OutliveTheServer) {
  StartWithAnnaTwiceAndBen();
  const SharedAnchor kept = Place(*anna_, AnchorVisibility::kPrivate);
  const SharedAnchor ended = Place(*anna_, AnchorVisibility::kPrivate);
  ASSERT_TRUE(Gets(*annas_other_, ended.id));
  StopServer();
  {
    const auto store = content::OpenSqliteStore(StorePath());
    ASSERT_TRUE(store);
    ASSERT_TRUE((*store)->Delete(RoomId("square"), ended.id, ended.revision));
  }
  StartServer(MakeRelease(2));  // everything lies 5 m farther east in it
  for (const DeviceSession* phone : {anna_.get(), annas_other_.get()}) {
    ASSERT_TRUE(Loses(*phone, ended.id));
    ASSERT_TRUE(Eventually([&] { return phone->HasSnapshot(); }));
    const auto found = FindAnchor(*phone, kept.id);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->map_from_anchor.translation().x(),
                kept.map_from_anchor.translation().x() + 5, 1e-9);
  }
  EXPECT_FALSE(FindAnchor(*ben_, kept.id));
}

TEST_F(PrivateAnchors, GoWithTheMapWhenAnotherReleaseGoesLive) {
  StartWithAnnaTwiceAndBen();
  const SharedAnchor secret = Place(*anna_, AnchorVisibility::kPrivate);
  ASSERT_TRUE(Gets(*annas_other_, secret.id));
  const mapping::Release release = MakeRelease(2);
  server_->Swap({release, support::BelievePrior(release)});
  for (const DeviceSession* phone : {anna_.get(), annas_other_.get()}) {
    EXPECT_TRUE(Eventually([&] {
      const auto found = FindAnchor(*phone, secret.id);
      return found && found->epoch == 2;
    }));
    EXPECT_NEAR(FindAnchor(*phone, secret.id)->map_from_anchor.translation().x(),
                secret.map_from_anchor.translation().x() + 5, 1e-9);
  }
  EXPECT_FALSE(FindAnchor(*ben_, secret.id));
}

TEST_F(PrivateAnchors, ExpireForTheirOwner) {
  StartWithAnnaTwiceAndBen();
  const SharedAnchor secret = Place(*anna_, AnchorVisibility::kPrivate);
  ASSERT_TRUE(Gets(*annas_other_, secret.id));
  const auto store = content::OpenSqliteStore(StorePath());
  ASSERT_TRUE(store);
  auto record = **(*store)->Find(RoomId("square"), secret.id);
  record.expires_utc_ms = 1'700'000'000'000;
  ASSERT_TRUE((*store)->Update(record, record.revision));
  EXPECT_TRUE(Loses(*anna_, secret.id));
  EXPECT_TRUE(Loses(*annas_other_, secret.id));
}

TEST_F(PrivateAnchors, AreItsOwnForAPhoneWithoutASecret) {
  StartWithAnnaTwiceAndBen();
  ASSERT_TRUE(StandingPhone(*ben_, {1, 1, 1}).Localise());
  const SharedAnchor secret = Place(*ben_, AnchorVisibility::kPrivate);
  EXPECT_EQ(secret.owner, ben_->id());
  EXPECT_TRUE(Gets(*ben_, secret.id));
  EXPECT_TRUE(HasNot(*annas_other_, secret.id));
}

TEST_F(PrivateAnchors, TheNameOfTheirOwnerDoesNotShowThem) {
  StartWithAnnaTwiceAndBen();
  const SharedAnchor secret = Place(*anna_, AnchorVisibility::kPrivate);
  DeviceOptions impostor = MakeDeviceOptions("Impostor");
  impostor.owner_secret = anna_->Standing().owner;  // which all that she places for the room tells
  const auto stranger = Join(impostor);
  ASSERT_NE(stranger, nullptr);
  EXPECT_TRUE(HasNot(*stranger, secret.id));

  DeviceOptions in_her_name = MakeDeviceOptions("Anna");
  in_her_name.id = anna_->id();
  in_her_name.request_timeout = std::chrono::seconds(1);
  EXPECT_FALSE(DeviceSession::Join(in_her_name)) << "here by another owner";
  EXPECT_TRUE(FindAnchor(*anna_, secret.id));
}

}  // namespace
}  // namespace waymark::session

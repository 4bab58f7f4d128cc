// SPDX-License-Identifier: Apache-2.0
// Two servers on one store: what happens to anchors on one is seen by the phones of the other.
#include "tests/content_store/postgres_server.h"
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::StandingPhone;

const RoomId kSquare("square");

/// A server with a phone that stands in its room, localised.
struct Site {
  void Start(const std::string& store, const std::string& name) {
    server = support::StartOnFreeDomain(options, [&] {
      auto opened = content::OpenStore(store);
      EXPECT_TRUE(opened) << ToString(opened.error());
      return support::MakeParts(support::MakeRelease(), *std::move(opened));
    });
    ASSERT_NE(server, nullptr);
    if (support::UsesGateway()) {
      auto started = Gateway::Start({.listen = {.port = 0}, .dds = {.domain = options.dds_domain}});
      ASSERT_TRUE(started) << ToString(started.error());
      gateway = *std::move(started);
    }
    auto joined = DeviceSession::Join(PhoneOptions(name));
    ASSERT_TRUE(joined) << ToString(joined.error());
    phone = *std::move(joined);
    StandingPhone standing(*phone, {3, 4, 1});
    ASSERT_TRUE(standing.Localise());
  }
  DeviceOptions PhoneOptions(const std::string& name) const {
    return {.server = gateway ? fmt::format("ws://127.0.0.1:{}", gateway->port()) : "127.0.0.1",
            .dds_domain = options.dds_domain,
            .room = kSquare,
            .name = name,
            .keyframe_interval = std::chrono::duration<double>(0.02),
            .request_timeout = support::seconds(30)};
  }
  void SwapTo(std::uint64_t epoch) {
    const mapping::Release release = support::MakeRelease(epoch);
    server->Swap({release, support::BelievePrior(release)});
    ASSERT_TRUE(Eventually([&] { return phone->DescribeMap().epoch == epoch; }));
  }

  ServerOptions options{.dds_domain = -1};
  std::unique_ptr<Server> server;
  std::unique_ptr<Gateway> gateway;  ///< null: the phone comes over DDS
  std::unique_ptr<DeviceSession> phone;
};

struct StoreKind {
  const char* name;
  bool is_postgres;
};

class SharedStore : public testing::TestWithParam<StoreKind> {
 protected:
  void SetUp() override {
    location_ = (folder_ / "anchors.db").string();
    if (GetParam().is_postgres) {
      const auto& postgres = content::SharedPostgres();
      if (!postgres) GTEST_SKIP() << ToString(postgres.error());
      location_ = (*postgres)->Uri();
      ASSERT_TRUE((*postgres)->Execute("DROP SCHEMA IF EXISTS waymark CASCADE"));
    }
    std::filesystem::create_directories(folder_);
    a_.Start(location_, "Anna");
    b_.Start(location_, "Ben");
    auto opened = content::OpenStore(location_);
    ASSERT_TRUE(opened);
    store_ = *std::move(opened);
  }
  ~SharedStore() override {
    for (Site* site : {&a_, &b_}) site->phone.reset();
    for (Site* site : {&a_, &b_}) site->gateway.reset();
    for (Site* site : {&a_, &b_}) site->server.reset();
    store_.reset();
    std::filesystem::remove_all(folder_);
  }

  SharedAnchor PlaceWith(Site& site) {
    const auto placed = site.phone->PlaceAnchor(kAhead, "note", "hello");
    EXPECT_TRUE(placed) << ToString(placed.error());
    return *placed;
  }
  /// The anchor as the phone of a site shows it once that is so.
  static ::testing::AssertionResult Shows(
      const Site& site, const AnchorId& id,
      const std::function<bool(const std::optional<SharedAnchor>&)>& condition) {
    if (Eventually([&] { return condition(FindAnchor(*site.phone, id)); })) {
      return ::testing::AssertionSuccess();
    }
    return ::testing::AssertionFailure() << "not so within a minute";
  }
  static bool IsThere(const std::optional<SharedAnchor>& anchor) { return anchor.has_value(); }
  static bool IsGone(const std::optional<SharedAnchor>& anchor) { return !anchor; }
  static auto IsAt(const Eigen::Vector3d& position, std::uint64_t epoch) {
    return [=](const std::optional<SharedAnchor>& anchor) {
      return anchor && anchor->epoch == epoch &&
             (anchor->map_from_anchor.translation() - position).norm() < 1e-9;
    };
  }
  /// An anchor that comes from elsewhere than a phone.
  content::AnchorRecord MakeRecord(std::uint64_t number) const {
    content::AnchorRecord record{.id = AnchorId(FormatUuid(UuidFromBits(9, number))),
                                 .room = kSquare,
                                 .owner = a_.phone->id().text()};
    record.place = support::MapOrigin();
    return record;
  }
  content::AnchorRecord Write(const Result<content::WriteOutcome>& outcome) {
    EXPECT_TRUE(outcome && std::holds_alternative<content::AnchorRecord>(*outcome));
    return std::get<content::AnchorRecord>(*outcome);
  }

  const std::filesystem::path folder_ =
      waymark::support::TemporaryRoot() / ("waymark_shared_" + std::to_string(::getpid()));
  std::string location_;
  Site a_, b_;
  std::unique_ptr<content::AnchorStore> store_;
};

TEST_P(SharedStore, PhonesOfOneServerSeeWhatThoseOfTheOtherDo) {
  const SharedAnchor placed = PlaceWith(a_);
  ASSERT_TRUE(Shows(b_, placed.id, IsAt(placed.map_from_anchor.translation(), 1)));
  EXPECT_EQ(FindAnchor(*b_.phone, placed.id)->payload, "hello");

  const Transform<Map, Anchor> there(Eigen::Quaterniond::Identity(), {6, 6, 2});
  const auto moved = a_.phone->MoveAnchor(placed, there);
  ASSERT_TRUE(moved) << ToString(moved.error());
  ASSERT_TRUE(Shows(b_, placed.id, IsAt({6, 6, 2}, 1)));

  // And the other one may go on from there.
  const Transform<Map, Anchor> back(Eigen::Quaterniond::Identity(), {5, 5, 1});
  ASSERT_TRUE(b_.phone->MoveAnchor(*FindAnchor(*b_.phone, placed.id), back));
  ASSERT_TRUE(Shows(a_, placed.id, IsAt({5, 5, 1}, 1)));
  ASSERT_TRUE(a_.phone->DeleteAnchor(*FindAnchor(*a_.phone, placed.id)));
  EXPECT_TRUE(Shows(b_, placed.id, IsGone));
  EXPECT_TRUE(Eventually([&] { return b_.phone->HasSnapshot(); }));
}

TEST_P(SharedStore, WhatExpiresVanishesForThosePresent) {
  content::AnchorRecord record = MakeRecord(1);
  record.expires_utc_ms = 95'617'584'000'000;
  record = Write(store_->Create(record));
  for (const Site* site : {&a_, &b_}) ASSERT_TRUE(Shows(*site, record.id, IsThere));
  record.expires_utc_ms = 1'700'000'000'000;
  Write(store_->Update(record, record.revision));
  for (const Site* site : {&a_, &b_}) EXPECT_TRUE(Shows(*site, record.id, IsGone));
}

TEST_P(SharedStore, WhatIsPrivateReachesNoOtherPhone) {
  content::AnchorRecord secret = MakeRecord(1);
  secret.visibility = content::AnchorVisibility::kPrivate;
  Write(store_->Create(secret));
  const content::AnchorRecord after = Write(store_->Create(MakeRecord(2)));
  ASSERT_TRUE(Shows(b_, after.id, IsThere)) << "what was written later has come";
  EXPECT_TRUE(Shows(a_, secret.id, IsThere)) << "its owner's";
  EXPECT_TRUE(IsGone(FindAnchor(*b_.phone, secret.id)));
  auto late = DeviceSession::Join(b_.PhoneOptions("Late"));
  ASSERT_TRUE(late);
  ASSERT_TRUE(Eventually([&] { return (*late)->HasSnapshot(); }));
  EXPECT_TRUE(IsGone(FindAnchor(**late, secret.id)));
  EXPECT_TRUE(IsThere(FindAnchor(**late, after.id)));
}

TEST_P(SharedStore, WhatIsPrivateIsSeenByItsOwnersPhonesOnEveryServer) {
  DeviceOptions options = a_.PhoneOptions("Carla");
  options.owner_secret = "carla's";
  auto here = DeviceSession::Join(options);
  options.dds_domain = b_.options.dds_domain;
  auto there = DeviceSession::Join(options);
  ASSERT_TRUE(here && there);
  ASSERT_TRUE(StandingPhone(**here, {3, 4, 1}).Localise());
  const auto placed =
      (*here)->PlaceAnchor(kAhead, "note", "mine", content::AnchorVisibility::kPrivate);
  ASSERT_TRUE(placed) << ToString(placed.error());
  ASSERT_TRUE(Eventually([&] { return FindAnchor(**there, placed->id).has_value(); }));
  const SharedAnchor after = PlaceWith(a_);
  ASSERT_TRUE(Shows(b_, after.id, IsThere));
  EXPECT_TRUE(IsGone(FindAnchor(*a_.phone, placed->id)));
  EXPECT_TRUE(IsGone(FindAnchor(*b_.phone, placed->id)));
  ASSERT_TRUE((*there)->DeleteAnchor(*FindAnchor(**there, placed->id)));
  EXPECT_TRUE(Eventually([&] { return !FindAnchor(**here, placed->id); }));
}

TEST_P(SharedStore, WhatComesFromAnotherReleaseIsShownInTheOwn) {
  const SharedAnchor before = PlaceWith(a_);
  ASSERT_TRUE(Shows(b_, before.id, IsThere));
  b_.SwapTo(2);  // a still serves release 1; the submap lies 5 m farther east in 2
  const SharedAnchor between = PlaceWith(a_);
  const Eigen::Vector3d position = between.map_from_anchor.translation();
  EXPECT_TRUE(Shows(b_, between.id, IsAt(position + Eigen::Vector3d(5, 0, 0), 2)));
  EXPECT_TRUE(Shows(b_, before.id, IsAt(position + Eigen::Vector3d(5, 0, 0), 2)));

  // The other way round: from the newer release to the older one.
  const Transform<Map, Anchor> there(Eigen::Quaterniond::Identity(), {16, 6, 2});
  const auto moved = b_.phone->MoveAnchor(*FindAnchor(*b_.phone, between.id), there);
  ASSERT_TRUE(moved) << ToString(moved.error());
  EXPECT_TRUE(Shows(a_, between.id, IsAt({11, 6, 2}, 1)));
  a_.SwapTo(2);
  EXPECT_TRUE(Shows(a_, between.id, IsAt({16, 6, 2}, 2)));
  EXPECT_TRUE(Shows(b_, between.id, IsAt({16, 6, 2}, 2)));
}

INSTANTIATE_TEST_SUITE_P(On, SharedStore,
                         testing::Values(StoreKind{"Sqlite", false}, StoreKind{"Postgres", true}),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace waymark::session

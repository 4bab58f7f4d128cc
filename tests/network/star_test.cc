// SPDX-License-Identifier: Apache-2.0
// Whole sessions over the networks of phones, while those and the programs fail.
#include <thread>

#include "tests/network/star_fixture.h"

namespace waymark::network {
namespace {

using session::DeviceSession;
using session::SharedAnchor;
using session::support::Eventually;
using session::support::FindAnchor;
using session::support::Sees;
using session::support::StandingPhone;

const Transform<Device, Anchor> kAhead{Eigen::Quaterniond::Identity(), {2, 0, 0}};

double SecondsSince(Instant begin) { return Seconds(std::chrono::steady_clock::now() - begin); }

/// Until another phone hears a new pose of this one: how long that takes.
double AwaitFreshPose(StandingPhone& phone, const DeviceSession& self, const DeviceSession& other) {
  const Instant begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(Eventually([&] {
    phone.Live();
    const auto seen = session::support::FindOther(other, self.id());
    return seen && seen->is_present && seen->map_from_device &&
           seen->age.count() < SecondsSince(begin);
  }));
  return SecondsSince(begin);
}

/// A network, and how phones on it reach the server.
struct Path {
  Way way;
  const char* profile;
};

class StarOn : public StarTest, public testing::WithParamInterface<Path> {
 protected:
  StarOn() { way_ = GetParam().way; }
  int AddHost() const { return StarTest::AddHost(GetParam().profile); }
  int AddGoodHost() const { return StarTest::AddHost("none"); }
};

std::string NameOf(const testing::TestParamInfo<Path>& info) {
  return std::string(info.param.way == Way::kBus ? "Bus" : "Gateway") + "_" + info.param.profile;
}

INSTANTIATE_TEST_SUITE_P(Networks, StarOn,
                         testing::Values(Path{Way::kGateway, "4g"}, Path{Way::kGateway, "3g"},
                                         Path{Way::kGateway, "crowded"}, Path{Way::kBus, "4g"},
                                         Path{Way::kBus, "3g"}, Path{Way::kBus, "crowded"}),
                         NameOf);

TEST_P(StarOn, PhonesShareAnAnchor) {
  const auto watcher = JoinAt(AddGoodHost(), "Watcher"), anna = JoinAt(AddHost(), "Anna");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto anchor = anna->PlaceAnchor(kAhead, "note", "shared");
  ASSERT_TRUE(anchor.ok()) << ToString(anchor.error());
  EXPECT_TRUE(Eventually([&] { return FindAnchor(*watcher, anchor->id).has_value(); }));
  AwaitFreshPose(phone, *anna, *watcher);
}

TEST_P(StarOn, AnOutageEndsAndNobodyBeginsAnew) {
  const int host = AddHost();
  const auto anna = JoinAt(host, "Anna"), watcher = JoinAt(AddGoodHost(), "Watcher");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  AwaitFreshPose(phone, *anna, *watcher);
  star_->emulator().Cut(host, true);
  const Instant cut = std::chrono::steady_clock::now();
  while (SecondsSince(cut) < 2) phone.Live();
  star_->emulator().Cut(host, false);
  const double back_s = AwaitFreshPose(phone, *anna, *watcher);
  EXPECT_EQ(anna->Pose().state, localiser::AlignmentState::kFixed);
  EXPECT_TRUE(anna->PlaceAnchor(kAhead, "note", "after").ok());
  RecordProperty("seen_again_after_ms", static_cast<int>(1e3 * back_s));
  fmt::print("seen again {:.1f} s after an outage of 2 s\n", back_s);
}

TEST_P(StarOn, APartitionHealsAndEverythingIsMadeUpFor) {
  const int host = AddHost();
  const auto anna = JoinAt(host, "Anna"), ben = JoinAt(AddHost(), "Ben");
  StandingPhone phone(*ben, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto doomed = ben->PlaceAnchor(kAhead, "note", "doomed");
  ASSERT_TRUE(doomed.ok());
  ASSERT_TRUE(Eventually([&] { return FindAnchor(*anna, doomed->id).has_value(); }));
  star_->emulator().Cut(host, true);
  EXPECT_TRUE(Eventually([&] { return !Sees(*ben, anna->id()); })) << "she is gone for him";
  const auto missed = ben->PlaceAnchor(kAhead, "note", "missed");
  ASSERT_TRUE(missed.ok());
  ASSERT_TRUE(ben->DeleteAnchor(*doomed).ok());
  star_->emulator().Cut(host, false);
  EXPECT_TRUE(
      Eventually([&] { return FindAnchor(*anna, missed->id) && !FindAnchor(*anna, doomed->id); }));
  EXPECT_TRUE(Eventually([&] { return Sees(*ben, anna->id()); }));
}

// Sockets of DDS stay on the address they were made at, so this is through the gateway alone.
TEST_F(StarTest, AnotherAddressIsTheSamePhone) {
  const int host = AddHost("4g");
  const auto anna = JoinAt(host, "Anna"), watcher = JoinAt(AddHost("none"), "Watcher");
  const DeviceId before = anna->id();
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto anchor = anna->PlaceAnchor(kAhead, "note", "before");
  ASSERT_TRUE(anchor.ok());
  AwaitFreshPose(phone, *anna, *watcher);
  ASSERT_TRUE(star_->emulator().ChangeAddress(host).ok());
  const double back_s = AwaitFreshPose(phone, *anna, *watcher);
  EXPECT_EQ(anna->id(), before);
  EXPECT_EQ(anna->Pose().state, localiser::AlignmentState::kFixed);
  const auto after = anna->PlaceAnchor(kAhead, "note", "after");
  ASSERT_TRUE(after.ok()) << ToString(after.error());
  EXPECT_EQ(after->owner, anchor->owner);
  EXPECT_EQ(watcher->Others().size(), 1u) << "there is one of her";
  fmt::print("heard again {:.1f} s after the address changed\n", back_s);
}

class StarKilled : public StarOn {};
INSTANTIATE_TEST_SUITE_P(Ways, StarKilled,
                         testing::Values(Path{Way::kGateway, "4g"}, Path{Way::kBus, "4g"}), NameOf);

/// Kills server and gateway, one after the other, while anchors are placed.
TEST_P(StarKilled, ProgramsLoseNothingAndDoubleNothing) {
  const auto anna = JoinAt(AddHost(), "Anna"), ben = JoinAt(AddHost(), "Ben");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  std::vector<SharedAnchor> placed;
  std::thread placing([&] {
    for (int i = 0; i < 60; ++i) {
      const auto anchor = anna->PlaceAnchor(kAhead, "note", std::to_string(i));
      EXPECT_TRUE(anchor.ok()) << ToString(anchor.error());
      if (anchor.ok()) placed.push_back(*anchor);
    }
  });
  EXPECT_TRUE(Eventually([&] { return ben->Anchors().size() > 10; }));
  EXPECT_TRUE(star_->RestartServer().ok());
  EXPECT_TRUE(Eventually([&] { return ben->Anchors().size() > 25; }));
  EXPECT_TRUE(star_->RestartGateway().ok());
  if (way_ == Way::kBus) {
    EXPECT_TRUE(star_->RestartServer().ok()) << "once more";
  }
  placing.join();
  EXPECT_EQ(placed.size(), 60u);
  EXPECT_TRUE(Eventually([&] { return ben->HasSnapshot() && ben->Anchors().size() == 60; }))
      << ben->Anchors().size();
  for (const SharedAnchor& anchor : placed) EXPECT_TRUE(FindAnchor(*ben, anchor.id));
  const auto late = JoinAt(StarTest::AddHost("3g"), "Late");
  EXPECT_TRUE(Eventually([&] { return late->HasSnapshot(); }));
  EXPECT_EQ(late->Anchors().size(), 60u);
  EXPECT_TRUE(Eventually([&] { return Sees(*ben, anna->id()) && Sees(*anna, ben->id()); }));
}

}  // namespace
}  // namespace waymark::network

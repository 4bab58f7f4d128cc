// SPDX-License-Identifier: Apache-2.0
// A phone behind the address translation of its carrier, whose address changes on both sides.
#include <optional>

#include "tests/network/star_fixture.h"

namespace waymark::network {
namespace {

using session::support::Eventually;
using session::support::StandingPhone;

const Transform<Device, Anchor> kAhead{Eigen::Quaterniond::Identity(), {2, 0, 0}};

class NatTest : public StarTest {
 protected:
  /// Puts a router with address translation on a host of the emulator, and a phone behind it.
  Result<void> PutPhoneBehind(int router) {
    const NetworkNamespace& outside = star_->emulator().Inside(router);
    WAYMARK_TRY(outside.Run({"ip", "link", "add", "lan0", "type", "veth", "peer", "name", "wan0",
                             "netns", phone_->Path()}));
    WAYMARK_TRY(outside.SetAddress("lan0", "192.168.7.1", "255.255.255.0"));
    WAYMARK_TRY(outside.Run({"sh", "-c", "echo 1 > /proc/sys/net/ipv4/ip_forward"}));
    WAYMARK_TRY(outside.Run({"nft", "add table ip nat"}));
    WAYMARK_TRY(
        outside.Run({"nft", "add chain ip nat post { type nat hook postrouting priority 100 ; }"}));
    WAYMARK_TRY(outside.Run({"nft", "add rule ip nat post oifname \"emu0\" masquerade"}));
    return Readdress("192.168.7.2");
  }

  Result<void> Readdress(const std::string& address) {
    WAYMARK_TRY(phone_->SetAddress("wan0", address, "255.255.255.0"));
    return phone_->Run({"ip", "route", "replace", "default", "via", "192.168.7.1"});
  }

  void SetUp() override {
    StarTest::SetUp();
    if (IsSkipped()) return;
    phone_.emplace(*NetworkNamespace::Create());
    router_ = AddHost("4g");
    if (const auto put = PutPhoneBehind(router_); !put) {
      GTEST_SKIP() << "no address translation here: " << put.error().message;
    }
  }

  int router_ = 0;
  std::optional<NetworkNamespace> phone_;
};

TEST_F(NatTest, ChangedAddressesOnBothSidesKeepIdentityAndPose) {
  const auto anna = JoinIn(*phone_, "Anna");
  ASSERT_NE(anna, nullptr);
  const auto watcher = JoinAt(AddHost("none"), "Watcher");
  const DeviceId before = anna->id();
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto anchor = anna->PlaceAnchor(kAhead, "note", "before");
  ASSERT_TRUE(anchor.ok());
  ASSERT_TRUE(star_->emulator().ChangeAddress(router_).ok());
  ASSERT_TRUE(Readdress("192.168.7.3").ok());
  const Instant changed = std::chrono::steady_clock::now();
  double back_s = 0;
  EXPECT_TRUE(Eventually([&] {
    phone.Live();
    const auto seen = session::support::FindOther(*watcher, before);
    back_s = Seconds(std::chrono::steady_clock::now() - changed);
    return seen && seen->is_present && seen->map_from_device && seen->age.count() < back_s;
  }));
  EXPECT_EQ(anna->id(), before);
  EXPECT_EQ(anna->Pose().state, localiser::AlignmentState::kFixed);
  const auto after = anna->PlaceAnchor(kAhead, "note", "after");
  ASSERT_TRUE(after.ok()) << ToString(after.error());
  EXPECT_EQ(after->owner, anchor->owner);
  EXPECT_EQ(watcher->Others().size(), 1u);
  RecordProperty("back_after_ms", static_cast<int>(1e3 * back_s));
  fmt::print("heard again {:.1f} s after both addresses changed behind NAT\n", back_s);
}

}  // namespace
}  // namespace waymark::network

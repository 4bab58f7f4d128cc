// SPDX-License-Identifier: Apache-2.0
// What is revoked while it is on the bus is put out, and what comes later is kept out, however good
// its credentials are.
#include "session/keys/revocations.h"
#include "tests/session/security_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::kAhead;
using support::kAnna;
using support::kMallory;
using support::kSquare;
using support::Peer;
using support::Sees;
using support::StandingPhone;

/// A server that asks for tokens too, and Anna, who places anchors.
class DdsRevocation : public support::SecurityTest {
 protected:
  void SetUp() override {
    MakeKeys();
    authority_ = *keys_;
    StartServer();
    anna_ = Join(WithToken(kAnna, Issue(kAnna)));
    ASSERT_NE(anna_, nullptr);
    phone_.emplace(*anna_, Eigen::Vector3d(3, 4, 1));
    ASSERT_TRUE(phone_->Localise());
  }

  DeviceOptions WithToken(const DeviceId& device, const std::string& credentials) const {
    DeviceOptions options = With(device, credentials);
    options.token = IssueToken(Role::kMember).token;
    return options;
  }
  void Revoke(std::string_view what, const std::string& id) const {
    const auto revoked = keys_->Revoke(what, id);
    ASSERT_TRUE(revoked.ok()) << ToString(revoked.error());
  }
  /// Something happens in the room of which others are told.
  void Happen() {
    phone_->Live();
    EXPECT_TRUE(anna_->PlaceAnchor(kAhead, "note", "for who is here").ok());
  }
  /// How much it has heard, once nothing more is on its way.
  static int Settle(Peer& peer) {
    int heard = -1;
    EXPECT_TRUE(Eventually([&] {
      const int before = std::exchange(heard, std::stoi(peer.Ask("speak")));
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      return heard == before;
    }));
    return heard;
  }
  void ExpectItHearsNoMore(Peer& peer) {
    const int heard = Settle(peer);
    for (int i = 0; i < 30; ++i) {
      Happen();
      EXPECT_EQ(std::stoi(peer.Ask("speak")), heard);
    }
  }

  std::unique_ptr<DeviceSession> anna_;
  std::optional<StandingPhone> phone_;
};

TEST_F(DdsRevocation, ADeviceThatIsHereLearnsWhyAndIsPutOut) {
  const auto ben = Join(WithToken(kMallory, Issue(kMallory)));
  ASSERT_NE(ben, nullptr);
  ASSERT_TRUE(Eventually([&] { return Sees(*anna_, kMallory); }));
  Revoke("device", kMallory.text());
  EXPECT_TRUE(Eventually([&] { return !Sees(*anna_, kMallory); }));
  EXPECT_TRUE(Eventually([&] { return !ben->Standing().reason.empty(); }));
  EXPECT_THAT(ben->Standing().reason, testing::HasSubstr("revoked"));
  EXPECT_TRUE(Eventually(
      [&] { return log_->Has(kMallory.text() + ": was revoked, its connection to DDS ends"); }));
  Happen();
}

// Without a token, and past the checks of its own side: it listens as long as DDS lets it.
TEST_F(DdsRevocation, WhoIsRevokedHearsNothingMoreAndDoesNotComeBack) {
  const std::string credentials = Issue(kMallory);
  const auto peer = Send(kMallory, credentials);
  EXPECT_TRUE(Eventually([&] {
    Happen();
    return std::stoi(peer->Ask("speak")) > 20;
  }));
  Revoke("device", kMallory.text());
  EXPECT_TRUE(Eventually([&] {
    (void)peer->Ask("speak");
    return log_->Has(kMallory.text() + ": was revoked, its connection to DDS ends");
  }));
  ExpectItHearsNoMore(*peer);
  const auto again = Send(kMallory, credentials);  // as a new participant
  EXPECT_TRUE(Eventually([&] {
    (void)again->Ask("speak");
    return log_->Has("credentials of \"" + kMallory.text() + "\": were revoked");
  }));
  ExpectItHearsNoMore(*again);
  EXPECT_EQ(again->Ask("speak"), "0");
  const std::uint64_t refusals = StopServer().refusals;
  EXPECT_GT(refusals, 0u) << "its Hellos before that";
}

TEST_F(DdsRevocation, WhoWasRevokedBeforeItCameDoesNotComeIn) {
  Revoke("device", kMallory.text());
  const std::string credentials = Issue(kMallory);  // new ones do not help
  EXPECT_TRUE(Eventually([&] { return log_->Has("1 devices"); }));
  const auto peer = Send(kMallory, credentials);
  EXPECT_TRUE(Eventually([&] {
    (void)peer->Ask("speak");
    return log_->Has("credentials of \"" + kMallory.text() + "\": were revoked");
  }));
  ExpectItHearsNoMore(*peer);
  EXPECT_EQ(peer->Ask("speak"), "0");
  EXPECT_EQ(StopServer().refusals, 0u) << "its Hello was not even heard";
}

TEST_F(DdsRevocation, ADeviceOnAnySliceIsPutOut) {
  anna_.reset();
  StopServer();
  options_.slices = 4;  // the room is on the third
  StartServer();
  const auto anna = Join(WithToken(kAnna, Issue(kAnna)));
  const auto ben = Join(WithToken(kMallory, Issue(kMallory)));
  ASSERT_TRUE(anna && ben);
  ASSERT_TRUE(Eventually([&] { return Sees(*anna, kMallory); }));
  Revoke("device", kMallory.text());
  EXPECT_TRUE(Eventually([&] { return !Sees(*anna, kMallory); }));
  EXPECT_TRUE(Eventually(
      [&] { return log_->Has(kMallory.text() + ": was revoked, its connection to DDS ends"); }));
  EXPECT_TRUE(anna->Standing().is_in);
}

// A restart knows the list from the beginning.
TEST_F(DdsRevocation, AServerThatStartsKnowsWhoIsRevoked) {
  const std::string credentials = Issue(kMallory);
  Revoke("device", kMallory.text());
  StopServer();
  StartServer();
  const auto peer = Send(kMallory, credentials);
  EXPECT_TRUE(Eventually([&] {
    (void)peer->Ask("speak");
    return log_->Has("credentials of \"" + kMallory.text() + "\": were revoked");
  }));
  EXPECT_EQ(peer->Ask("speak"), "0");
  EXPECT_EQ(StopServer().refusals, 0u);
}

TEST_F(DdsRevocation, AGatewayThatIsRevokedIsPutOutWithItsPhones) {
  const auto credentials =
      keys_->Issue({.kind = Kind::kGateway, .name = "edge", .validity = support::ForAnHour()});
  ASSERT_TRUE(credentials.ok()) << ToString(credentials.error());
  auto gateway = Gateway::Start(
      {.dds = {.domain = domain_, .security_folder = credentials->string()}, .door = OpenDoor()});
  ASSERT_TRUE(gateway.ok()) << ToString(gateway.error());
  DeviceOptions options = WithToken(kMallory, "");
  options.server = fmt::format("ws://127.0.0.1:{}", (*gateway)->port());
  const auto ben = Join(options);
  ASSERT_NE(ben, nullptr);
  ASSERT_TRUE(Eventually([&] { return Sees(*anna_, kMallory); }));
  Revoke("gateway", "edge");
  EXPECT_TRUE(Eventually([&] { return !Sees(*anna_, kMallory); }));
  EXPECT_TRUE(log_->Has("edge: was revoked, its connection to DDS ends"));
  Happen();
}

TEST(Revocations, NamesAreThoseOfCertificates) {
  const auto list = keys::ParseRevocations(
      "device 11234567-89AB-4DEF-BEDC-BA9876543210\ngateway edge\ntoken t\nkey k\n");
  ASSERT_TRUE(list.ok()) << ToString(list.error());
  EXPECT_THAT(list->Names(), testing::UnorderedElementsAre(kMallory.text(), "edge"));
  const auto authority = keys::CertificateAuthority::Make("test", support::ForAnHour());
  ASSERT_TRUE(authority.ok());
  const auto name_of = [&](const std::string& name) {
    const keys::Validity validity = support::ForAnHour();
    const auto facts = keys::ReadCertificate(authority->Issue(name, validity)->certificate_pem);
    EXPECT_EQ(facts.until, validity.until);
    return facts.name;
  };
  EXPECT_EQ(name_of("edge"), "edge");
  EXPECT_EQ(name_of("11234567-89AB-4DEF-BEDC-BA9876543210"), kMallory.text());
  EXPECT_EQ(keys::ReadCertificate("no certificate").name, "");
}

}  // namespace
}  // namespace waymark::session

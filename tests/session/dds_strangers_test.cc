// SPDX-License-Identifier: Apache-2.0
// Who has not the right credentials is refused by the server itself, whatever checks its own side
// leaves out: it reads nothing, writes nothing, and the server's log says so.
#include "tests/session/security_fixture.h"

namespace waymark::session {
namespace {

using keys::Authority;
using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::kAnna;
using support::kMallory;
using support::Peer;
using support::Sees;
using support::StandingPhone;

class DdsStrangers : public support::SecurityTest {
 protected:
  void SetUp() override {
    SecurityTest::SetUp();
    anna_ = Join(With(kAnna, Issue(kAnna)));
    ASSERT_NE(anna_, nullptr);
    phone_.emplace(*anna_, Eigen::Vector3d(3, 4, 1));
    ASSERT_TRUE(phone_->Localise());
    Place(content::AnchorVisibility::kRoom);
    Place(content::AnchorVisibility::kPrivate);
  }

  void Place(content::AnchorVisibility visibility) {
    const auto placed = anna_->PlaceAnchor(kAhead, "note", "secret", visibility);
    ASSERT_TRUE(placed.ok()) << ToString(placed.error());
    ++placed_;
  }

  /// Life in the room goes on meanwhile.
  void ExpectNothingReadNorWritten(Peer& stranger, const std::string& log) {
    EXPECT_TRUE(Eventually([&] {
      (void)stranger.Ask("speak");
      return log_->Has(log);
    })) << log;
    Place(content::AnchorVisibility::kRoom);
    Place(content::AnchorVisibility::kPrivate);
    for (int i = 0; i < 30; ++i) {
      phone_->Live();
      EXPECT_EQ(stranger.Ask("speak"), "0") << "heard";
    }
    EXPECT_EQ(anna_->Others().size(), 0u);
    EXPECT_EQ(anna_->Anchors().size(), placed_);
    const ServerCounters counters = StopServer();
    EXPECT_EQ(counters.joins, 1u);
    EXPECT_EQ(counters.refusals, 0u) << "its Hello was not even heard";
    EXPECT_EQ(counters.anchor_commands, placed_);
    EXPECT_EQ(counters.rejected_messages, 0u);
  }

  std::unique_ptr<DeviceSession> anna_;
  std::optional<StandingPhone> phone_;
  std::size_t placed_ = 0;
};

// What the others do not get, so that their silence says something.
TEST_F(DdsStrangers, WithCredentialsOfItsOwnItReadsAndWrites) {
  const auto peer = Send(kMallory, Issue(kMallory));
  EXPECT_TRUE(Eventually([&] {
    phone_->Live();
    return std::stoi(peer->Ask("speak")) > 20 && Sees(*anna_, kMallory);
  }));
  EXPECT_GT(StopServer().anchor_commands, placed_);
}

TEST_F(DdsStrangers, WithoutACertificate) {
  const auto stranger = Send(kMallory, "-");
  ExpectNothingReadNorWritten(*stranger, "has shown no credentials");
}

TEST_F(DdsStrangers, WithACertificateOfAnotherAuthority) {
  const auto other = Authority::Create(folder_ / "other");
  ASSERT_TRUE(other.ok());
  const std::string folder = Issue(kMallory, "square", support::ForAnHour(), &*other);
  const auto stranger = Send(kMallory, folder);
  ExpectNothingReadNorWritten(
      *stranger,
      "Certificate not valid: error: certificate signature failure; subject: "
      "/O=Waymark/CN=" +
          kMallory.text());
}

TEST_F(DdsStrangers, WithACertificateThatHasEnded) {
  const std::string folder = Issue(kMallory, "square", support::Past());
  Copy(Issue(kMallory) + "/permissions.p7s", folder + "/permissions.p7s");
  const auto stranger = Send(kMallory, folder);
  ExpectNothingReadNorWritten(*stranger,
                              "certificate has expired; subject: /O=Waymark/CN=" + kMallory.text());
}

TEST_F(DdsStrangers, WithItsOwnPermissionsOfLastTime) {
  const std::string folder = Issue(kMallory);
  Copy(Issue(kMallory, "square", support::Past()) + "/permissions.p7s",
       folder + "/permissions.p7s");
  const auto stranger = Send(kMallory, folder, "not_after>20", "not_after>21");
  ExpectNothingReadNorWritten(*stranger, "period expired for CN=" + kMallory.text());
}

TEST_F(DdsStrangers, WithThePermissionsOfAnotherDevice) {
  const std::string folder = Issue(kMallory);
  Copy(Issue(kAnna) + "/permissions.p7s", folder + "/permissions.p7s");
  const auto stranger = Send(kAnna, folder, "CN=" + kAnna.text(), "CN=" + kMallory.text());
  ExpectNothingReadNorWritten(
      *stranger, "permissions of \"" + kMallory.text() + "\": Subject name is invalid");
}

TEST_F(DdsStrangers, WithPermissionsForAnotherRoom) {
  const auto stranger = Send(kMallory, Issue(kMallory, "garden"), "room.garden.", "room.square.");
  ExpectNothingReadNorWritten(*stranger, kMallory.text() + ": reads \"waymark/");
}

// CVE-2023-24011: this Cyclone takes permissions signed by any certificate that the permissions
// authority vouches for. The server has one for permissions that never vouches for a device.
TEST_F(DdsStrangers, WithPermissionsThatItSignedItself) {
  const std::string folder = Issue(kMallory, "garden");
  const auto device = keys::CertificateAuthority::FromPem(
      *LoadTextFile(folder + "/certificate.pem"), *LoadTextFile(folder + "/key.pem"));
  ASSERT_TRUE(device.ok());
  const auto forged =
      device->SignDocument(keys::PermissionsXml({.subject = "CN=" + kMallory.text() + ",O=Waymark",
                                                 .validity = support::ForAnHour(),
                                                 .writes = {"*"},
                                                 .reads = {"*"}}));
  ASSERT_TRUE(forged.ok());
  ASSERT_TRUE(StoreFileAtomically(folder + "/permissions.p7s", std::string_view(*forged)).ok());
  const auto stranger = Send(kMallory, folder);
  ExpectNothingReadNorWritten(*stranger, "unable to get local issuer certificate");
}

TEST_F(DdsStrangers, WhoseCredentialsEndIsNotHeardFromThenOn) {
  const auto peer =
      Send(kMallory, Issue(kMallory, "square", support::For(std::chrono::seconds(10))));
  EXPECT_TRUE(Eventually([&] {
    phone_->Live();
    return std::stoi(peer->Ask("speak")) > 20 && Sees(*anna_, kMallory);
  }));
  EXPECT_TRUE(Eventually([&] {
    (void)peer->Ask("speak");
    return !Sees(*anna_, kMallory) && log_->Has(kMallory.text() + ": its credentials have ended");
  }));
  const std::string heard = peer->Ask("speak");
  Place(content::AnchorVisibility::kRoom);
  for (int i = 0; i < 30; ++i) {
    phone_->Live();
    EXPECT_EQ(peer->Ask("speak"), heard);
  }
}

}  // namespace
}  // namespace waymark::session

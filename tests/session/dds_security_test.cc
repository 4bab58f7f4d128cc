// SPDX-License-Identifier: Apache-2.0
// DDS Security with real participants: who has not the right credentials reads nothing and writes
// nothing.
#include "mapping/base/file.h"
#include "session/keys/certificates.h"
#include "session/keys/dds_documents.h"
#include "session/wire/internal/topics.h"
#include "session/wire/room_line.h"
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using keys::Authority;
using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::Sees;
using support::StandingPhone;
using Kind = Authority::Request::Kind;

const DeviceId kAnna("01234567-89ab-4def-bedc-ba9876543210");
const DeviceId kMallory("11234567-89ab-4def-bedc-ba9876543210");
const RoomId kSquare("square");

keys::Validity ForAnHour() {
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  return {now - std::chrono::minutes(5), now + std::chrono::hours(1)};
}

class DdsSecurity : public support::SessionTest {
 protected:
  void SetUp() override {
    auto made = Authority::Create(folder_ / "keys");
    ASSERT_TRUE(made.ok()) << ToString(made.error());
    keys_.emplace(*std::move(made));
    options_.security_folder =
        keys_->Issue({.kind = Kind::kServer, .name = "main", .validity = ForAnHour()})->string();
    StartServer();
  }

  std::string Issue(const DeviceId& device, const std::string& room = "square",
                    const keys::Validity& validity = ForAnHour()) const {
    const auto folder = keys_->Issue({.kind = Kind::kDevice,
                                      .name = device.text(),
                                      .room = room,
                                      .validity = validity,
                                      .out = folder_ / ("credentials_" + device.text() + room)});
    EXPECT_TRUE(folder.ok()) << ToString(folder.error());
    return folder.ok() ? folder->string() : "";
  }
  DeviceOptions With(const DeviceId& device, const std::string& credentials) const {
    DeviceOptions options = MakeDeviceOptions("phone");
    options.server = "127.0.0.1";
    options.id = device;
    options.security_folder = credentials;
    return options;
  }
  /// As With, for those who are expected to wait in vain.
  Result<std::unique_ptr<DeviceSession>> Try(const DeviceId& device,
                                             const std::string& credentials) const {
    DeviceOptions options = With(device, credentials);
    options.request_timeout = std::chrono::seconds(3);
    return DeviceSession::Join(options);
  }
  void ExpectNobodyCame() { EXPECT_EQ(StopServer().joins, 0u); }

  static void Copy(const std::string& from, const std::string& to) {
    std::filesystem::copy_file(from, to, std::filesystem::copy_options::overwrite_existing);
  }

  std::optional<Authority> keys_;
};

TEST_F(DdsSecurity, WhoHasCredentialsLivesAsEver) {
  const auto anna = Join(With(kAnna, Issue(kAnna)));
  ASSERT_NE(anna, nullptr);
  const auto ben = Join(With(kMallory, Issue(kMallory)));
  ASSERT_NE(ben, nullptr);
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto anchor = anna->PlaceAnchor(kAhead, "note", "secret");
  ASSERT_TRUE(anchor.ok()) << ToString(anchor.error());
  EXPECT_TRUE(Eventually([&] { return FindAnchor(*ben, anchor->id) && Sees(*ben, kAnna); }));
}

TEST_F(DdsSecurity, WithoutACertificateNothingIsReadOrWritten) {
  const auto anna = Join(With(kAnna, Issue(kAnna)));
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  auto plain = dds::Participant::Create({.domain = domain_, .server = "127.0.0.1"});
  ASSERT_TRUE(plain.ok());
  std::atomic<int> heard = 0;
  const auto line = wire::RoomLine::Create(
      std::make_shared<dds::Participant>(*std::move(plain)), kSquare, [&](const auto&) { ++heard; },
      [] {});
  ASSERT_TRUE(line.ok());
  EXPECT_FALSE(Try(kMallory, "").ok());
  for (int i = 0; i < 30; ++i) phone.Live();
  EXPECT_EQ(heard, 0);
  EXPECT_EQ(anna->Others().size(), 0u);
  EXPECT_EQ(StopServer().joins, 1u);
}

TEST_F(DdsSecurity, AnotherAuthorityDoesNotCount) {
  const auto stranger = Authority::Create(folder_ / "stranger");
  ASSERT_TRUE(stranger.ok());
  const auto folder = stranger->Issue(
      {.kind = Kind::kDevice, .name = kMallory.text(), .room = "square", .validity = ForAnHour()});
  ASSERT_TRUE(folder.ok());
  EXPECT_FALSE(Try(kMallory, folder->string()).ok());
  ExpectNobodyCame();
}

TEST_F(DdsSecurity, WhatHasExpiredDoesNotCount) {
  keys::Validity past = ForAnHour();
  past.from -= std::chrono::hours(10);
  past.until = past.from + std::chrono::hours(1);
  EXPECT_FALSE(Try(kMallory, Issue(kMallory, "square", past)).ok());
  ExpectNobodyCame();
}

// CVE-2023-24011: this Cyclone takes permissions signed by any certificate that the permissions
// authority vouches for. On its own side an attacker names the identity authority so, and is let
// through there; the server has an authority for permissions that never vouches for a device.
TEST_F(DdsSecurity, PermissionsThatADeviceSignedItselfDoNotCount) {
  const std::string folder = Issue(kMallory, "garden");
  const auto device = keys::CertificateAuthority::FromPem(
      *LoadTextFile(folder + "/certificate.pem"), *LoadTextFile(folder + "/key.pem"));
  ASSERT_TRUE(device.ok());
  const std::string subject = "CN=" + kMallory.text() + ",O=Waymark";
  const auto forged = device->SignDocument(keys::PermissionsXml(
      {.subject = subject, .validity = ForAnHour(), .writes = {"*"}, .reads = {"*"}}));
  const auto governance = device->SignDocument(keys::GovernanceXml());
  ASSERT_TRUE(forged.ok() && governance.ok());
  Copy(folder + "/identity_ca.pem", folder + "/permissions_ca.pem");
  ASSERT_TRUE(StoreFileAtomically(folder + "/permissions.p7s", std::string_view(*forged)).ok());
  ASSERT_TRUE(StoreFileAtomically(folder + "/governance.p7s", std::string_view(*governance)).ok());
  EXPECT_FALSE(Try(kMallory, folder).ok());
  ExpectNobodyCame();
}

TEST_F(DdsSecurity, ItIsGoodForItsRoomAndDeviceAlone) {
  EXPECT_FALSE(Try(kMallory, Issue(kMallory, "garden")).ok()) << "another room";
  EXPECT_FALSE(Try(kAnna, Issue(kMallory)).ok()) << "another device";
  ExpectNobodyCame();
}

TEST_F(DdsSecurity, NobodyElseReadsWhatADeviceIsToldOfItsOwnersAnchors) {
  const auto anna = Join(With(kAnna, Issue(kAnna)));
  ASSERT_NE(anna, nullptr);
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const std::string credentials = Issue(kMallory);
  const auto ben = Join(With(kMallory, credentials));
  ASSERT_NE(ben, nullptr);
  auto participant = dds::Participant::Create(
      {.domain = domain_, .server = "127.0.0.1", .security_folder = credentials});
  ASSERT_TRUE(participant.ok()) << ToString(participant.error());
  std::atomic<std::uint64_t> rejected = 0;
  std::atomic<int> heard = 0;
  const auto listen = [&](const std::string& partition) {
    return wire::MakeReader<AnchorState>(*participant, partition, rejected,
                                         [&](const AnchorState&) { ++heard; });
  };
  const auto annas = listen(wire::DevicePartition(kSquare, kAnna));
  const auto gateways = listen(wire::GatewayDownPartition(kSquare));
  const auto secret =
      anna->PlaceAnchor(kAhead, "note", "secret", content::AnchorVisibility::kPrivate);
  ASSERT_TRUE(secret.ok()) << ToString(secret.error());
  const auto later = anna->PlaceAnchor(kAhead, "note", "for all");
  ASSERT_TRUE(later.ok()) << ToString(later.error());
  ASSERT_TRUE(Eventually([&] { return FindAnchor(*ben, later->id).has_value(); }));
  EXPECT_TRUE(FindAnchor(*anna, secret->id));
  EXPECT_FALSE(FindAnchor(*ben, secret->id));
  EXPECT_EQ(heard, 0);
}

// With good credentials of its own, and no library of ours to hold it back.
TEST_F(DdsSecurity, WhoSpeaksInAnothersNameIsNotHeard) {
  const auto anna = Join(With(kAnna, Issue(kAnna)));
  ASSERT_NE(anna, nullptr);
  const std::string credentials = Issue(kMallory);
  auto ben = Join(With(kMallory, credentials));
  ASSERT_NE(ben, nullptr);
  auto participant = dds::Participant::Create(
      {.domain = domain_, .server = "127.0.0.1", .security_folder = credentials});
  ASSERT_TRUE(participant.ok()) << ToString(participant.error());
  auto writer = wire::MakeWriter<Hello>(*participant, wire::UpPartition(kSquare, kMallory));
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE(Eventually([&] { return writer->HasReaders(); }));
  // Anna's goodbye, and the coming of somebody who is not there, until the server has heard them.
  const DeviceId ghost("21234567-89ab-4def-bedc-ba9876543210");
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(wire::Write(*writer, Hello{.device = ghost, .room = kSquare, .name = "g"}).ok());
    EXPECT_TRUE(wire::Write(*writer, Hello{.device = kAnna, .room = kSquare, .name = "g"}).ok());
    waymark_Hello key{};
    wire::SetId(key.device, kAnna);
    EXPECT_TRUE(writer->Dispose(&key).ok());
    (void)writer->WaitForAcknowledgements(std::chrono::milliseconds(100));
  }
  EXPECT_TRUE(Sees(*ben, kAnna));
  EXPECT_FALSE(Sees(*ben, ghost));
  StandingPhone phone(*anna, {3, 4, 1});
  EXPECT_TRUE(phone.Localise());
  const ServerCounters counters = StopServer();
  EXPECT_EQ(counters.joins, 2u);
  EXPECT_GT(counters.rejected_messages, 0u);
}

TEST_F(DdsSecurity, FilesThatAreMissingAreNamed) {
  const std::string folder = Issue(kMallory);
  std::filesystem::remove(folder + "/permissions.p7s");
  const auto session = Try(kMallory, folder);
  ASSERT_FALSE(session.ok());
  EXPECT_EQ(session.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(session.error().message, testing::HasSubstr("permissions.p7s"));
}

}  // namespace
}  // namespace waymark::session

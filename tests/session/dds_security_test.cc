// SPDX-License-Identifier: Apache-2.0
// DDS Security with real participants: what those with good credentials may do, and may not.
#include "session/wire/internal/topics.h"
#include "tests/session/security_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::kAnna;
using support::kMallory;
using support::kSquare;
using support::Sees;
using support::StandingPhone;

class DdsSecurity : public support::SecurityTest {};

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

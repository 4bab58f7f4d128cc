// SPDX-License-Identifier: Apache-2.0
// Whole sessions over DDS on loopback, while servers and devices die and packets are lost.
#include "tests/session/peer.h"
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::Sees;
using support::StandingPhone;
using testing::HasSubstr;

class SessionFailure : public support::SessionTest {
 protected:
  /// For a device in a process of its own, on the same way as those of this one.
  std::vector<std::string> DeviceWords(const std::string& name) const {
    return {"device", MakeDeviceOptions(name).server, std::to_string(domain_), name};
  }
};

TEST_F(SessionFailure, ARestartedServerLosesNothingAndDevicesFindItAgain) {
  StartServer();
  const auto anna = Join("Anna"), ben = Join("Ben");
  StandingPhone anna_phone(*anna, {3, 4, 1});
  ASSERT_TRUE(anna_phone.Localise());
  const auto kept = anna->PlaceAnchor(kAhead, "note", "kept");
  const auto doomed = anna->PlaceAnchor(kAhead, "note", "doomed");
  ASSERT_TRUE(kept.ok() && doomed.ok());
  ASSERT_TRUE(Eventually([&] { return ben->Anchors().size() == 2; }));

  StopServer();
  EXPECT_EQ(ben->Anchors().size(), 2u) << "content does not vanish with the server";
  {
    auto store = content::OpenSqliteStore(StorePath());
    ASSERT_TRUE(store.ok());
    ASSERT_TRUE((*store)->Delete(RoomId("square"), doomed->id, doomed->revision).ok());
  }
  StartServer();
  ASSERT_TRUE(Eventually([&] {
    return anna->Statistics().joins == 2 && ben->Statistics().joins == 2 && ben->HasSnapshot();
  }));
  EXPECT_TRUE(Eventually([&] { return ben->Anchors().size() == 1; }));
  EXPECT_TRUE(FindAnchor(*ben, kept->id));
  EXPECT_TRUE(Eventually([&] { return Sees(*ben, anna->id()); }));
  // Anna is the same device as before, and her earlier fixes still hold: the map is the same.
  const auto more = anna->PlaceAnchor(kAhead, "note", "more");
  ASSERT_TRUE(more.ok()) << ToString(more.error());
  EXPECT_EQ(more->owner, kept->owner);
  EXPECT_TRUE(Eventually([&] { return FindAnchor(*ben, more->id).has_value(); }));
}

TEST_F(SessionFailure, LossOnlyDelays) {
  options_.transmit_loss_per_mille = 150;
  device_loss_per_mille_ = 150;
  StartServer();
  const auto anna = Join("Anna"), ben = Join("Ben");
  StandingPhone anna_phone(*anna, {3, 4, 1});
  ASSERT_TRUE(anna_phone.Localise());
  std::vector<SharedAnchor> placed;
  for (int i = 0; i < 20; ++i) {
    const auto anchor = anna->PlaceAnchor(kAhead, "note", std::string(5000, 'x'));
    ASSERT_TRUE(anchor.ok()) << ToString(anchor.error());
    placed.push_back(*anchor);
  }
  ASSERT_TRUE(anna->DeleteAnchor(placed.front()).ok());
  EXPECT_TRUE(Eventually(
      [&] { return ben->Anchors().size() == 19 && !FindAnchor(*ben, placed.front().id); }));
  const auto late = Join("Late");
  EXPECT_TRUE(Eventually([&] { return late->HasSnapshot() && late->Anchors().size() == 19; }));
}

TEST_F(SessionFailure, AKilledDeviceIsGoneWithinTheLease) {
  StartServer();
  const auto anna = Join("Anna");
  constexpr int kKilled = 3;
  std::array<std::optional<support::Peer>, kKilled> devices;
  for (auto& device : devices) {
    device.emplace(DeviceWords("Ben"));
    ASSERT_TRUE(Eventually([&] { return Sees(*anna, DeviceId(device->line())); }))
        << device->line();
  }
  double sum_s = 0;
  for (auto& device : devices) device->Kill();
  const auto killed = std::chrono::steady_clock::now();
  for (const auto& device : devices) {
    EXPECT_TRUE(Eventually([&] { return !Sees(*anna, DeviceId(device->line())); }));
    sum_s += Seconds(std::chrono::steady_clock::now() - killed);
  }
  RecordProperty("gone_after_ms", static_cast<int>(1e3 * sum_s / kKilled));
  // The lease is 3 s; the rest is for machines that are busy.
  EXPECT_LT(sum_s / kKilled, 9) << "mean of " << kKilled;
}

// An app that the phone halts for longer than the lease, and lets go on.
TEST_F(SessionFailure, APausedDeviceComesBackAsItself) {
  StartServer();
  const auto anna = Join("Anna");
  support::Peer ben(DeviceWords("Ben"));
  const DeviceId ben_id(ben.line());
  ASSERT_TRUE(Eventually([&] { return Sees(*anna, ben_id); })) << ben.line();
  ben.Pause();
  EXPECT_TRUE(Eventually([&] { return !Sees(*anna, ben_id); }));
  ben.Continue();
  EXPECT_TRUE(Eventually([&] { return Sees(*anna, ben_id); }));
  EXPECT_TRUE(Eventually([&] { return ben.Ask("?").starts_with("returns=1 "); }));
}

TEST_F(SessionFailure, AKilledServerLosesNothingThatItAcknowledged) {
  StartServer();  // finds a free domain
  StopServer();
  auto serving = std::make_unique<support::Peer>(
      std::vector<std::string>{"server", std::to_string(domain_), StorePath().string()});
  ASSERT_EQ(serving->line(), "serving");
  const auto anna = Join("Anna");
  StandingPhone anna_phone(*anna, {3, 4, 1});
  ASSERT_TRUE(anna_phone.Localise());
  std::vector<SharedAnchor> acknowledged;
  std::thread placing([&] {
    for (int i = 0; i < 200; ++i) {
      const auto anchor = anna->PlaceAnchor(kAhead, "note", std::to_string(i));
      if (anchor.ok()) acknowledged.push_back(*anchor);
    }
  });
  EXPECT_TRUE(Eventually([&] { return anna->Anchors().size() > 20; }));
  serving->Kill();
  serving = std::make_unique<support::Peer>(
      std::vector<std::string>{"server", std::to_string(domain_), StorePath().string()});
  EXPECT_EQ(serving->line(), "serving");
  placing.join();
  EXPECT_EQ(acknowledged.size(), 200u) << "a command under way is repeated to the new server";

  const auto late = Join("Late");
  ASSERT_TRUE(Eventually([&] { return late->HasSnapshot(); }));
  EXPECT_EQ(late->Anchors().size(), 200u) << "neither lost nor doubled";
  for (const SharedAnchor& anchor : acknowledged) EXPECT_TRUE(FindAnchor(*late, anchor.id));
}

TEST_F(SessionFailure, AServerThatIsNotThereIsNamed) {
  StartServer();
  DeviceOptions options = MakeDeviceOptions("Anna");
  StopServer();
  options.request_timeout = std::chrono::milliseconds(300);
  const auto session = DeviceSession::Join(options);
  ASSERT_FALSE(session.ok());
  EXPECT_EQ(session.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(session.error().message, HasSubstr("127.0.0.1"));
  EXPECT_THAT(session.error().message, HasSubstr("waymark-serve"));
  options.server = "no such host";
  EXPECT_EQ(DeviceSession::Join(options).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
// Whole sessions over DDS on loopback, while servers and devices die and packets are lost.
#include <mutex>

#include "session/device/internal/links.h"
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
  /// One over DDS and one through a gateway.
  std::vector<std::unique_ptr<DeviceSession>> JoinOnBothWays() {
    std::vector<std::unique_ptr<DeviceSession>> both;
    DeviceOptions options = MakeDeviceOptions("Anna");
    options.server = "127.0.0.1";
    both.push_back(Join(options));
    auto gateway = Gateway::Start({.listen = {.port = 0}, .dds = {.domain = domain_}});
    EXPECT_TRUE(gateway.ok()) << ToString(gateway.error());
    other_gateway_ = *std::move(gateway);
    options.name = "Cleo";
    options.server = fmt::format("ws://127.0.0.1:{}", other_gateway_->port());
    both.push_back(Join(options));
    return both;
  }

  std::unique_ptr<Gateway> other_gateway_;
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

// Who is killed is gone for all, whichever way they and it came.
TEST_F(SessionFailure, AKilledDeviceIsGoneForAllWithinTheLease) {
  StartServer();
  const std::vector<std::unique_ptr<DeviceSession>> others = JoinOnBothWays();
  const auto is_gone = [&](const DeviceId& device) {
    return std::none_of(others.begin(), others.end(),
                        [&](const auto& other) { return Sees(*other, device); });
  };
  std::array<std::optional<support::Peer>, 3> devices;
  for (auto& device : devices) {
    device.emplace(DeviceWords("Ben"));
    ASSERT_TRUE(Eventually([&] {
      return std::all_of(others.begin(), others.end(),
                         [&](const auto& other) { return Sees(*other, DeviceId(device->line())); });
    })) << device->line();
  }
  for (auto& device : devices) device->Kill();
  const auto killed = std::chrono::steady_clock::now();
  std::chrono::duration<double> last{0};
  for (const auto& device : devices) {
    EXPECT_TRUE(Eventually([&] { return is_gone(DeviceId(device->line())); }));
    last = std::chrono::steady_clock::now() - killed;
  }
  // The lease is a promise, the rest is for machines that are busy.
  EXPECT_LT(last, options_.state.presence_timeout + std::chrono::seconds(3));
  RecordProperty("gone_after_ms", static_cast<int>(1e3 * last.count()));
}

// An app that the phone halts for longer than the lease, and lets go on.
TEST_F(SessionFailure, APausedDeviceComesBackAsItself) {
  StartServer();
  const std::vector<std::unique_ptr<DeviceSession>> others = JoinOnBothWays();
  support::Peer ben(DeviceWords("Ben"));
  const DeviceId ben_id(ben.line());
  const auto sees = [&](const auto& other) { return Sees(*other, ben_id); };
  const auto all_see = [&] { return std::all_of(others.begin(), others.end(), sees); };
  ASSERT_TRUE(Eventually(all_see)) << ben.line();
  ben.Pause();
  EXPECT_TRUE(Eventually([&] { return std::none_of(others.begin(), others.end(), sees); }));
  ben.Continue();
  EXPECT_TRUE(Eventually(all_see));
  EXPECT_TRUE(Eventually([&] { return ben.Ask("?").starts_with("returns=1 "); }));
}

// Anna stands still, Cleo leaves meanwhile. Whenever their apps go on, all see who is there.
TEST_F(SessionFailure, WhoWasPausedSeesWhoIsThereAndNobodyElse) {
  StartServer();
  const auto anna = Join("Anna");
  auto cleo = Join("Cleo");
  std::array<std::optional<support::Peer>, 4> paused;
  for (auto& device : paused) device.emplace(DeviceWords("Ben"));
  const auto all_say = [&](const std::string& others) {
    return std::all_of(paused.begin(), paused.end(), [&](auto& device) {
      return device->Ask("?").find(" in=yes others=" + others + " ") != std::string::npos;
    });
  };
  ASSERT_TRUE(Eventually([&] { return all_say("5"); })) << paused.front()->Ask("?");
  for (auto& device : paused) device->Pause();
  cleo.reset();
  const auto is_gone = [&](const auto& device) { return !Sees(*anna, DeviceId(device->line())); };
  EXPECT_TRUE(Eventually([&] { return std::all_of(paused.begin(), paused.end(), is_gone); }));
  for (auto& device : paused) {
    device->Continue();
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
  }
  EXPECT_TRUE(Eventually([&] { return all_say("4"); })) << paused.front()->Ask("?");
}

// What a device knows is over only when it is told anew, and what is told anew comes after that.
TEST_F(SessionFailure, WhoIsToldAllAnewIsToldSoFirst) {
  StartServer();
  const auto anna = Join("Anna");
  std::mutex mutex;
  bool is_anew = false, is_known = false;  // guarded by mutex
  const DeviceId ben("01234567-89ab-4def-bedc-ba9876543210");
  const DeviceOptions options = MakeDeviceOptions("Ben");
  const auto link = internal::MakeLink(options, ben, [&](const wire::DeviceLink::Event& event) {
    const std::lock_guard lock(mutex);
    const auto* const lost = std::get_if<wire::DeviceLink::DeviceLost>(&event);
    if ((lost && lost->device == anna->id()) ||
        std::holds_alternative<wire::DeviceLink::ToldAnew>(event)) {
      is_anew = true;
      is_known = false;
    }
    const auto* const message = std::get_if<wire::Downward>(&event);
    const auto* const presence = message ? std::get_if<Presence>(message) : nullptr;
    if (presence && presence->device == anna->id()) is_known = true;
  });
  ASSERT_TRUE(link.ok()) << ToString(link.error());
  const auto is_told = [&](std::uint32_t attempt, bool is_expected_anew) {
    return Eventually([&] {
      (void)(*link)->Send(Hello{.device = ben,
                                .protocol = kProtocol,
                                .attempt = attempt,
                                .room = options.room,
                                .name = "Ben"});
      const std::lock_guard lock(mutex);
      return is_known && is_anew == is_expected_anew;
    });
  };
  ASSERT_TRUE(is_told(1, support::UsesGateway()));
  is_anew = false;
  StopServer();
  StartServer();
  EXPECT_TRUE(is_told(2, true));
}

// The same app, halted for longer than a seat is kept.
TEST_F(SessionFailure, ADeviceThatPausesForTooLongComesBackAsANewcomer) {
  options_.state.return_within = std::chrono::milliseconds(1);
  options_.state.max_members = 2;
  StartServer();
  const auto anna = Join("Anna");
  support::Peer ben(DeviceWords("Ben"));
  const DeviceId ben_id(ben.line());
  ASSERT_TRUE(Eventually([&] { return Sees(*anna, ben_id); })) << ben.line();
  ben.Pause();
  DeviceOptions options = MakeDeviceOptions("Cleo");
  std::unique_ptr<DeviceSession> cleo;
  EXPECT_TRUE(Eventually([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));  // doors count failures
    auto joined = DeviceSession::Join(options);
    if (joined.ok()) cleo = *std::move(joined);
    return cleo != nullptr;
  })) << "his seat becomes free";
  EXPECT_FALSE(Sees(*anna, ben_id));
  ben.Continue();
  EXPECT_TRUE(Eventually([&] { return ben.Ask("?").find("holds its 2") != std::string::npos; }));
  cleo.reset();
  EXPECT_TRUE(Eventually([&] { return Sees(*anna, ben_id); }));
  EXPECT_TRUE(Eventually([&] { return ben.Ask("?").find(" in=yes ") != std::string::npos; }));
  EXPECT_THAT(ben.Ask("?"), testing::StartsWith("returns=0 "));
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

TEST_F(SessionFailure, WhatAModeratorDecidedOutlivesAKilledServer) {
  AskForTokens();
  StartServer();  // finds a free domain
  StopServer();
  const std::vector<std::string> words{"server", std::to_string(domain_), StorePath().string(),
                                       authority_->folder().string()};
  auto serving = std::make_unique<support::Peer>(words);
  ASSERT_EQ(serving->line(), "serving");
  DeviceOptions options = MakeDeviceOptions("Anna");
  options.token = IssueToken(Role::kModerator).token;
  const auto anna = Join(options);
  ASSERT_NE(anna, nullptr);
  std::vector<std::string> ben_words = DeviceWords("Ben");
  ben_words.push_back(IssueToken(Role::kMember).token);
  support::Peer ben(ben_words);
  ASSERT_TRUE(Eventually([&] { return Sees(*anna, DeviceId(ben.line())); })) << ben.line();
  ASSERT_TRUE(anna->SetCapacity(2).ok());
  ASSERT_TRUE(anna->Kick(DeviceId(ben.line()), "sells shoes").ok());

  serving->Kill();
  serving = std::make_unique<support::Peer>(words);
  ASSERT_EQ(serving->line(), "serving");
  ASSERT_TRUE(Eventually([&] { return anna->Statistics().joins == 2; }));
  EXPECT_THAT(support::Peer(ben_words).line(), HasSubstr("sells shoes; may come back in"));
  const auto join = [&](const std::string& name) {
    DeviceOptions other = MakeDeviceOptions(name);
    other.token = IssueToken(Role::kMember).token;
    return DeviceSession::Join(other);
  };
  const auto cleo = join("Cleo");
  ASSERT_TRUE(cleo.ok()) << ToString(cleo.error());
  const auto dora = join("Dora");
  ASSERT_FALSE(dora.ok());
  EXPECT_THAT(dora.error().message, HasSubstr("holds its 2 devices"));
  // So does what she takes back.
  ASSERT_TRUE(anna->SetCapacity(3).ok());
  ASSERT_TRUE(anna->Readmit(DeviceId(ben.line())).ok());
  serving->Kill();
  serving = std::make_unique<support::Peer>(words);
  ASSERT_TRUE(Eventually([&] { return anna->Statistics().joins == 3; }));
  const support::Peer again(ben_words);
  EXPECT_TRUE(Eventually([&] { return Sees(*anna, DeviceId(again.line())); })) << again.line();
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

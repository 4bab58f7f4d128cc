// SPDX-License-Identifier: Apache-2.0
// Somebody sets the wall clock of a machine by an hour, and back, while phones are in a room.
#include <fstream>

#include "tests/session/peer.h"
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::Peer;
using testing::HasSubstr;
using testing::StartsWith;

/// A process whose wall clock can be set.
class SteppedPeer {
 public:
  SteppedPeer(std::filesystem::path clock, const std::string& program,
              const std::vector<std::string>& arguments)
      : clock_(std::move(clock)) {
    SetClock(std::chrono::hours(0));
    std::vector<std::string> words{"LD_PRELOAD=" STEPPED_CLOCK_LIBRARY,
                                   "STEPPED_CLOCK=" + clock_.string(),
                                   "ASAN_OPTIONS=verify_asan_link_order=0", program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    peer_.emplace(words, "/usr/bin/env");
  }

  /// So far ahead of what it would be.
  void SetClock(std::chrono::nanoseconds ahead) const {
    // In place, because the process has the file mapped.
    std::fstream file(clock_, std::ios::in | std::ios::out | std::ios::binary);
    if (!file) file.open(clock_, std::ios::out | std::ios::binary);
    const std::int64_t ns = ahead.count();
    file.write(reinterpret_cast<const char*>(&ns), sizeof ns);
  }
  Peer& peer() { return *peer_; }

 private:
  const std::filesystem::path clock_;
  std::optional<Peer> peer_;
};

class ClockStep : public support::SessionTest {
 protected:
  void SetUp() override {
    AskForTokens();
    StartServer();  // finds a free domain
    StopServer();
    const std::string domain = std::to_string(domain_), keys = authority_->folder().string();
    Add(SESSION_PEER, {"server", domain, StorePath().string(), keys});
    ASSERT_EQ(processes_[kServer]->peer().line(), "serving");
    Add(WAYMARK_GATEWAY, {"--domain", domain, "--port", "0", "--security", keys});
    const std::string& ready = processes_[kGateway]->peer().line();
    ASSERT_THAT(ready, StartsWith("ready"));
    const std::string port = ready.substr(ready.find("port=") + 5);
    gateway_url_ = "ws://127.0.0.1:" + port.substr(0, port.find(' '));
    AddPhone("127.0.0.1", "Anna");
    AddPhone(gateway_url_, "Ben");
  }

  void Add(const std::string& program, const std::vector<std::string>& arguments) {
    processes_.push_back(std::make_unique<SteppedPeer>(
        folder_ / fmt::format("clock{}", processes_.size()), program, arguments));
  }
  void AddPhone(const std::string& server, const std::string& name) {
    Add(SESSION_PEER, {"device", server, std::to_string(domain_), name, TokenOfThisMorning()});
    ASSERT_EQ(processes_.back()->peer().line().size(), 36u) << processes_.back()->peer().line();
  }
  /// Good for two hours before and after now.
  std::string TokenOfThisMorning() const {
    const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
    const auto issued = authority_->IssueToken({.room = RoomId("square"),
                                                .role = Role::kMember,
                                                .issued = now - std::chrono::hours(2),
                                                .expires = now + std::chrono::hours(2)});
    EXPECT_TRUE(issued.ok());
    return issued->token;
  }

  Peer& anna() { return processes_[kAnna]->peer(); }
  Peer& ben() { return processes_[kBen]->peer(); }

  /// Each places an anchor, and both see both.
  void ShareAnchors() {
    EXPECT_EQ(anna().Ask("place hers"), "placed");
    EXPECT_EQ(ben().Ask("place his"), "placed");
    anchors_ += 2;
    const std::string all = fmt::format("in=yes others=1 anchors={}", anchors_);
    for (Peer* const phone : {&anna(), &ben()}) {
      EXPECT_TRUE(Eventually([&] { return phone->Ask("?").ends_with(all); })) << phone->Ask("?");
    }
  }
  void SetClocks(const std::vector<int>& processes, std::chrono::hours ahead) const {
    for (const int i : processes) processes_[i]->SetClock(ahead);
  }
  static bool HasOthers(Peer& phone, int count) {
    return phone.Ask("?").find(fmt::format(" others={} ", count)) != std::string::npos;
  }
  /// How often each phone had to find the server again or was away.
  std::string Interruptions() {
    std::string all;
    for (Peer* const phone : {&anna(), &ben()}) {
      const std::string standing = phone->Ask("?");
      all += standing.substr(0, standing.find(" in="));
    }
    return all;
  }

  static constexpr int kServer = 0, kGateway = 1, kAnna = 2, kBen = 3;
  std::vector<std::unique_ptr<SteppedPeer>> processes_;
  std::string gateway_url_;
  int anchors_ = 0;
};

TEST_F(ClockStep, ByAnHourAndBackAnywhereThrowsNobodyOut) {
  const std::vector<std::vector<int>> machines{
      {kServer}, {kGateway}, {kAnna}, {kBen}, {kServer, kGateway, kAnna, kBen}};
  ShareAnchors();
  for (const auto& stepped : machines) {
    SCOPED_TRACE(fmt::format("{} clocks from process {}", stepped.size(), stepped[0]));
    // A machine that is too busy for pings interrupts as well, but not each time.
    bool is_harmless = false;
    for (int attempt = 0; attempt < 5 && !is_harmless; ++attempt) {
      const std::string before = Interruptions();
      for (const int hour : {1, 0, -1, 0}) {
        SetClocks(stepped, std::chrono::hours(hour));
        for (int i = 0; i < 3; ++i) ShareAnchors();
      }
      is_harmless = Interruptions() == before;
    }
    EXPECT_TRUE(is_harmless) << Interruptions();
  }
}

TEST_F(ClockStep, BackByAnHourStopsNeitherJoinsNorLeases) {
  SetClocks({kServer, kGateway, kAnna, kBen}, std::chrono::hours(-1));
  for (const std::string& server : {std::string("127.0.0.1"), gateway_url_}) {
    AddPhone(server, "Cleo");
    Peer& cleo = processes_.back()->peer();
    EXPECT_TRUE(Eventually([&] { return HasOthers(cleo, 2) && HasOthers(anna(), 2); }));
    cleo.Kill();
    EXPECT_TRUE(Eventually([&] { return HasOthers(anna(), 1) && HasOthers(ben(), 1); }));
  }
}

TEST_F(ClockStep, DoorsGoByTheWallClockAndWhoIsInStays) {
  const std::string token = TokenOfThisMorning();
  SetClocks({kServer, kGateway}, std::chrono::hours(5));
  ShareAnchors();
  for (const std::string& server : {std::string("127.0.0.1"), gateway_url_}) {
    DeviceOptions options = MakeDeviceOptions("Late");
    options.server = server;
    options.token = token;
    const auto late = DeviceSession::Join(options);
    ASSERT_FALSE(late.ok()) << server;
    EXPECT_THAT(late.error().message, HasSubstr("expired"));
  }
  ShareAnchors();
}

}  // namespace
}  // namespace waymark::session

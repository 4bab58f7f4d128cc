// SPDX-License-Identifier: Apache-2.0
// A device on the bus says as much as it can, without a library of ours that paces it. The others
// do not notice.
#include "session/wire/device_bus.h"
#include "tests/session/security_fixture.h"
#include "tests/session/wire_fixture.h"

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

/// A device that says each thing once, so that what is lost is seen.
class Witness {
 public:
  static constexpr int kRounds = 150;

  explicit Witness(const dds::ParticipantOptions& options) {
    auto participant = dds::Participant::Create(options);
    EXPECT_TRUE(participant.ok()) << ToString(participant.error());
    auto bus = wire::DeviceBus::Create(
        std::make_shared<dds::Participant>(*std::move(participant)), kSquare, kAnna,
        [this](const wire::DeviceLink::Event& event) { Hear(event); });
    EXPECT_TRUE(bus.ok()) << ToString(bus.error());
    bus_ = *std::move(bus);
    EXPECT_TRUE(Eventually([&] {
      (void)bus_->Send(Hello{.device = kAnna, .room = kSquare, .name = "witness"});
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      return ticket_.load() != Ticket{};
    }));
  }

  /// Three seconds of a phone's life.
  void Live() {
    waymark::support::RandomGeometry random(1);
    for (std::uint32_t round = 0; round < kRounds; ++round) {
      (void)bus_->Send(PoseReport{.ticket = ticket_, .pose = {}});
      (void)bus_->Send(ClockPing{ticket_, round, {}});
      AnchorCommand command = wire::MakeCommand(random);
      command.ticket = ticket_;
      command.request = UuidFromBits(1000, round);
      (void)bus_->Send(std::move(command));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  int replies() const { return replies_; }
  int pongs() const { return pongs_; }

 private:
  void Hear(const wire::DeviceLink::Event& event) {
    const auto* const message = std::get_if<wire::Downward>(&event);
    if (message == nullptr) return;
    if (const auto* welcome = std::get_if<Welcome>(message)) ticket_ = welcome->ticket;
    replies_ += std::holds_alternative<CommandReply>(*message);
    pongs_ += std::holds_alternative<ClockPong>(*message);
  }

  std::atomic<Ticket> ticket_{};
  std::atomic<int> replies_ = 0, pongs_ = 0;
  std::unique_ptr<wire::DeviceBus> bus_;  // last: its threads use the rest
};

/// On open DDS, and on DDS with authentication and encryption.
class DdsFlood : public support::SecurityTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    MakeKeys();
    if (!GetParam()) options_.security_folder.clear();
    StartServer();
  }
  std::string CredentialsOf(const DeviceId& device) { return GetParam() ? Issue(device) : ""; }
};

TEST_P(DdsFlood, ThatOneDeviceMakesCostsTheOthersNothing) {
  const DeviceId ben("21234567-89ab-4def-bedc-ba9876543210");
  const auto session = Join(With(ben, CredentialsOf(ben)));
  ASSERT_NE(session, nullptr);
  StandingPhone phone(*session, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto flooder = Send(kMallory, GetParam() ? Issue(kMallory) : "-");
  ASSERT_TRUE(Eventually([&] { return flooder->Ask("flood") != "0"; }));
  ASSERT_TRUE(Eventually([&] { return log_->Has(kMallory.text() + ": says too much"); }));

  Witness witness(
      {.domain = domain_, .server = "127.0.0.1", .security_folder = CredentialsOf(kAnna)});
  std::thread living([&] { witness.Live(); });
  for (int i = 0; i < 20; ++i) {
    phone.Live();
    EXPECT_TRUE(session->PlaceAnchor(kAhead, "note", "hello").ok());
    EXPECT_TRUE(Sees(*session, kAnna)) << "nobody is taken for gone";
  }
  living.join();
  EXPECT_TRUE(Eventually([&] { return witness.replies() == Witness::kRounds; }))
      << witness.replies();
  EXPECT_GT(witness.pongs(), Witness::kRounds / 2) << "best effort, on a machine that is full";
  EXPECT_TRUE(phone.Localise());
  const auto said = std::stoull(flooder->Ask("flood"));
  const ServerCounters counters = StopServer();
  fmt::print("of {} messages of the flood {} were throttled; the witness heard {} pongs of {}\n",
             said, counters.throttled_messages, witness.pongs(), Witness::kRounds);
  EXPECT_GT(counters.throttled_messages, 1000u);
  EXPECT_EQ(counters.dropped_messages, 0u);
  EXPECT_EQ(counters.departures, 0u);
}

INSTANTIATE_TEST_SUITE_P(Both, DdsFlood, testing::Bool(), [](const auto& parameter) {
  return parameter.param ? "Secured" : "Open";
});

}  // namespace
}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
// The edge: connections that break, come from elsewhere, say too much or nonsense.
#include "session/gateway/gateway.h"

#include <atomic>
#include <future>

#include "session/wire/frames.h"
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::kAhead;
using support::Sees;
using support::StandingPhone;

class GatewayTest : public support::SessionTest {
 protected:
  void SetUp() override {
    StartServer();
    if (!gateway_) StartGateway();
  }
};

/// A client that is no device library.
class RawClient {
 public:
  explicit RawClient(std::uint16_t port) {
    std::promise<std::shared_ptr<socket::Channel>> connected;
    const auto begun =
        socket::Connect(loop_, {.host = "127.0.0.1", .port = port},
                        [&](Result<std::shared_ptr<socket::Channel>> channel) {
                          connected.set_value(channel.ok() ? *std::move(channel) : nullptr);
                        });
    EXPECT_TRUE(begun.ok());
    channel_ = connected.get_future().get();
    if (!channel_) return;
    channel_->Start({.on_frame = [this](std::span<const std::uint8_t> frame) { Hear(frame); },
                     .on_end =
                         [this](const Error& why) {
                           reason = why.message;
                           has_ended = true;
                         }});
  }
  ~RawClient() {
    loop_.Stop();
    channel_.reset();
  }

  void Send(const wire::Upward& message) { SendBytes(wire::EncodeFrame(message)); }
  void SendBytes(std::vector<std::uint8_t> bytes) {
    channel_->Send(std::move(bytes), std::nullopt);
  }

  bool is_connected() const { return channel_ != nullptr; }

  std::atomic<int> frames = 0, replies = 0, pongs = 0;
  std::atomic<Ticket> ticket{};
  std::atomic<bool> has_ended = false;
  std::string reason;  // once it has ended

 private:
  void Hear(std::span<const std::uint8_t> frame) {
    ++frames;
    const auto message = wire::DecodeDownward(frame);
    if (!message) return;
    if (const auto* welcome = std::get_if<Welcome>(&*message)) ticket = welcome->ticket;
    replies += std::holds_alternative<CommandReply>(*message);
    pongs += std::holds_alternative<ClockPong>(*message);
  }

  socket::SocketLoop loop_{1};
  std::shared_ptr<socket::Channel> channel_;
};

Hello MakeHello(const DeviceId& device, const std::string& room = "square") {
  return {.device = device, .attempt = 1, .room = RoomId(room), .name = "raw"};
}

TEST_F(GatewayTest, AGatewayThatComesBackIsFoundAndNobodyWasGone) {
  const auto anna = Join("Anna");
  StandingPhone phone(*anna, {3, 4, 1});
  ASSERT_TRUE(phone.Localise());
  const auto anchor = anna->PlaceAnchor(kAhead, "note", "before");
  ASSERT_TRUE(anchor.ok());
  const std::uint16_t port = gateway_->port();
  gateway_.reset();
  StartGateway(port);
  const auto after = anna->PlaceAnchor(kAhead, "note", "after");
  ASSERT_TRUE(after.ok()) << ToString(after.error());
  EXPECT_EQ(after->owner, anchor->owner);
  EXPECT_TRUE(Eventually([&] { return anna->Anchors().size() == 2; }));
  phone.Live();
  EXPECT_EQ(anna->Pose().state, localiser::AlignmentState::kFixed) << "the pose outlives it";
}

TEST_F(GatewayTest, ADeviceThatComesFromElsewhereIsItself) {
  const auto ben = Join("Ben");
  const auto anna = Join("Anna");
  ASSERT_TRUE(Eventually([&] { return Sees(*ben, anna->id()); }));
  // As if her network had changed: another connection says who she is.
  RawClient elsewhere(gateway_->port());
  elsewhere.Send(MakeHello(anna->id()));
  EXPECT_TRUE(Eventually([&] { return elsewhere.frames > 0; }));
  // Her own library was sent away, and comes back in turn.
  EXPECT_TRUE(Eventually([&] { return elsewhere.has_ended.load(); }));
  EXPECT_THAT(elsewhere.reason, testing::HasSubstr("came back on another connection"));
  EXPECT_TRUE(Sees(*ben, anna->id())) << "she was never gone";
  StandingPhone phone(*anna, {3, 4, 1});
  EXPECT_TRUE(phone.Localise());
  anna->Leave();
  EXPECT_TRUE(Eventually([&] { return !Sees(*ben, anna->id()); }));
  EXPECT_GE(gateway_->Stop().returns, 2u);
  gateway_.reset();
}

TEST_F(GatewayTest, ADeviceFromTheBusIsAnsweredThroughTheGatewayWhenItComesThere) {
  DeviceOptions on_the_bus = MakeDeviceOptions("Anna");
  on_the_bus.server = "127.0.0.1";
  const auto anna = Join(on_the_bus);
  const auto ben = Join("Ben");
  ASSERT_TRUE(Eventually([&] { return Sees(*ben, anna->id()); }));
  RawClient elsewhere(gateway_->port());
  EXPECT_TRUE(Eventually([&] {
    elsewhere.Send(MakeHello(anna->id()));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return elsewhere.frames > 0;
  }));
  EXPECT_TRUE(Sees(*ben, anna->id()));
  // And back: her library, which hears nothing any more, joins again.
  StandingPhone phone(*anna, {3, 4, 1});
  EXPECT_TRUE(phone.Localise());
  EXPECT_TRUE(anna->PlaceAnchor(kAhead, "note", "back").ok());
}

TEST_F(GatewayTest, AConnectionThatBreaksIsGoneForTheOthersInTime) {
  const auto ben = Join("Ben");
  const DeviceId raw("01234567-89ab-4def-bedc-ba9876543210");
  {
    RawClient client(gateway_->port());
    ASSERT_TRUE(Eventually([&] {
      client.Send(MakeHello(raw));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      return Sees(*ben, raw);
    }));
  }
  const auto cut = std::chrono::steady_clock::now();
  EXPECT_TRUE(Eventually([&] { return !Sees(*ben, raw); }));
  RecordProperty("gone_after_ms",
                 static_cast<int>(1e3 * Seconds(std::chrono::steady_clock::now() - cut)));
}

TEST_F(GatewayTest, NonsenseIsNotListenedToForEver) {
  RawClient client(gateway_->port());
  for (int i = 0; i < 30; ++i) client.SendBytes({1, 0, 0, 0, 9, 9, 9});
  EXPECT_TRUE(Eventually([&] { return client.has_ended.load(); }));
  const auto anna = Join("Anna");
  EXPECT_NE(anna, nullptr) << "the others do not notice";
  EXPECT_GE(gateway_->Stop().rejected, 20u);
  gateway_.reset();
}

TEST_F(GatewayTest, WhoDoesNotSayWhoItIsIsSentAway) {
  RawClient client(gateway_->port());
  client.Send(ClockPing{});
  EXPECT_TRUE(Eventually([&] { return client.has_ended.load(); }));
  EXPECT_THAT(client.reason, testing::HasSubstr("Hello first"));
}

TEST_F(GatewayTest, OneConnectionSpeaksForOneDevice) {
  RawClient client(gateway_->port());
  client.Send(MakeHello(DeviceId("01234567-89ab-4def-bedc-ba9876543210")));
  client.Send(MakeHello(DeviceId("11234567-89ab-4def-bedc-ba9876543210")));
  EXPECT_TRUE(Eventually([&] { return client.has_ended.load(); }));
  EXPECT_THAT(client.reason, testing::HasSubstr("another device"));
}

TEST_F(GatewayTest, WhoSaysTooMuchIsThrottledAndTheRestDoesNotNotice) {
  RawClient client(gateway_->port());
  client.Send(MakeHello(DeviceId("01234567-89ab-4def-bedc-ba9876543210")));
  const auto anna = Join("Anna");
  StandingPhone phone(*anna, {3, 4, 1});
  for (int i = 0; i < 5000; ++i) client.Send(ClockPing{Ticket{1}, 1, {}});
  EXPECT_TRUE(phone.Localise());
  EXPECT_TRUE(anna->PlaceAnchor(kAhead, "note", "hello").ok());
  EXPECT_GT(gateway_->Stop().throttled, 1000u);
  gateway_.reset();
}

/// Says Hello until it is welcomed, as phones do: the first may come before the room's line is up.
bool Enters(RawClient& client, const DeviceId& device) {
  return Eventually([&] {
    if (client.ticket.load() != Ticket{}) return true;
    client.Send(MakeHello(device));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    return false;
  });
}

// A phone that says each thing once, alone and then beside one that says as much as it can.
TEST_F(GatewayTest, BesideAFloodEverythingIsAnsweredAsWithoutIt) {
  constexpr int kRounds = 100;
  const auto live = [&](const DeviceId& device) {
    RawClient phone(gateway_->port());
    EXPECT_TRUE(Enters(phone, device));
    for (std::uint32_t round = 0; round < kRounds; ++round) {
      phone.Send(ClockPing{phone.ticket, round, {}});
      phone.Send(AnchorCommand{.ticket = phone.ticket,
                               .request = UuidFromBits(1000, round),
                               .operation = AnchorOperation::kMove,
                               .anchor = AnchorId(device.text())});
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_TRUE(Eventually([&] { return phone.replies == kRounds && phone.pongs == kRounds; }))
        << phone.replies << " replies, " << phone.pongs << " pongs";
  };
  live(DeviceId("01234567-89ab-4def-bedc-ba9876543210"));

  std::atomic<bool> is_over = false;
  std::thread flood([&] {
    const DeviceId device("21234567-89ab-4def-bedc-ba9876543210");
    RawClient client(gateway_->port());
    EXPECT_TRUE(Enters(client, device));
    for (std::uint32_t round = 0; !is_over; ++round) {
      client.Send(ClockPing{client.ticket, round, {}});
      client.Send(PoseReport{.ticket = client.ticket, .pose = {}});
      client.Send(AnchorCommand{.ticket = client.ticket,
                                .request = UuidFromBits(1, round),
                                .operation = AnchorOperation::kMove,
                                .anchor = AnchorId(device.text())});
      if (round % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
  live(DeviceId("11234567-89ab-4def-bedc-ba9876543210"));
  is_over = true;
  flood.join();
  EXPECT_GT(gateway_->Stop().throttled, 1000u);
  gateway_.reset();
  EXPECT_EQ(StopServer().dropped_messages, 0u);
}

TEST_F(GatewayTest, ATakenPortIsNamed) {
  const auto second =
      Gateway::Start({.listen = {.port = gateway_->port()}, .dds = {.domain = domain_}});
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kConflict);
  EXPECT_THAT(second.error().message, testing::HasSubstr(std::to_string(gateway_->port())));
}

TEST_F(GatewayTest, AGatewayThatIsNotThereIsNamed) {
  DeviceOptions options = MakeDeviceOptions("Anna");
  options.server = "ws://127.0.0.1:1";
  options.request_timeout = std::chrono::milliseconds(300);
  const auto session = DeviceSession::Join(options);
  ASSERT_FALSE(session.ok());
  EXPECT_THAT(session.error().message, testing::HasSubstr("ws://127.0.0.1:1"));
  for (const char* address :
       {"ws://", "wss://:80", "ws://host:0", "ws://host:70000", "ws://[::1:80", "wss://host:8x"}) {
    options.server = address;
    EXPECT_EQ(DeviceSession::Join(options).error().code, ErrorCode::kInvalidArgument) << address;
  }
}

}  // namespace
}  // namespace waymark::session

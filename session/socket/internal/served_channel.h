// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>

#include "session/socket/channel.h"
#include "session/socket/internal/byte_stream.h"
#include "session/socket/internal/descriptor.h"
#include "session/socket/internal/web_socket_frames.h"

namespace waymark::session::socket::internal {

class Carrier;
using OnChannel = std::function<void(std::shared_ptr<Channel>)>;

/// One accepted connection, from its handshakes to its end. What Channel says is thread-safe, all
/// else is called by its carrier, one at a time.
class ServedChannel final : public Channel, public std::enable_shared_from_this<ServedChannel> {
 public:
  using Instant = std::chrono::steady_clock::time_point;

  /// `context` null: without TLS. Hands itself over once it is a WebSocket.
  ServedChannel(Descriptor descriptor, SSL_CTX* context, std::string peer, OnChannel on_open,
                std::weak_ptr<Carrier> carrier);

  void Start(ChannelEvents events) override;
  void Send(wire::SharedFrame frame, std::optional<wire::Slot> slot) override;
  void SendParts(std::vector<wire::SharedFrame> parts) override;
  std::size_t WaitingPartBytes() const override { return outbox_.WaitingPartBytes(); }
  void Close(std::string why) override;
  void Abort() override;
  const std::string& peer() const override { return peer_; }

  int descriptor() const { return descriptor_.number(); }
  bool has_ended() const { return phase_ == Phase::kEnded; }
  /// What it waits for, as epoll says it.
  std::uint32_t WantedEvents() const;
  /// Reads what has come. `buffer` is lent.
  void Read(std::span<std::uint8_t> buffer, Instant now);
  /// Sends what waits, many frames at once. `buffer` is lent.
  void Write(std::vector<std::uint8_t>& buffer, Instant now);
  /// Ends what took too long; call it several times a second.
  void Tend(Instant now);

 private:
  enum class Phase { kShaking, kUpgrading, kOpen, kHasSaidGoodbye, kEnded };

  Result<void> ReadAll(std::span<std::uint8_t> buffer);
  Result<void> Take(std::span<std::uint8_t> bytes);
  Result<void> TakeRequest(std::span<std::uint8_t> bytes);
  bool OnMessage(Opcode opcode, std::span<const std::uint8_t> payload);
  void TakeEvents();
  Result<void> WriteAll(std::vector<std::uint8_t>& buffer);
  /// False: the network takes no more now.
  Result<bool> WriteSome(std::span<const std::uint8_t> bytes);
  void SayGoodbye(Instant now);
  void Wake();
  void End(const Error& why);

  Descriptor descriptor_;
  const std::unique_ptr<ByteStream> stream_;
  const std::string peer_;
  const std::weak_ptr<Carrier> carrier_;
  wire::Outbox outbox_{kMaxWaitingBytes};
  std::atomic<bool> is_too_slow_ = false, is_given_up_ = false;

  std::mutex mutex_;
  std::optional<std::string> farewell_;    // guarded by mutex_
  std::optional<ChannelEvents> starting_;  // guarded by mutex_; until its carrier takes them

  // Used by its carrier alone.
  Phase phase_ = Phase::kShaking;
  OnChannel on_open_;
  ChannelEvents events_;
  std::string request_;
  FrameReader reader_{kMaxFrameBytes};
  std::vector<std::uint8_t> unsent_;  // goes before all that waits
  Instant heard_;
  bool is_started_ = false, is_asked_ = false;
  std::optional<Instant> ends_at_;  // of its handshakes, then of its goodbye
};

}  // namespace waymark::session::socket::internal

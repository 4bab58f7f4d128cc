// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "session/socket/socket_loop.h"
#include "session/wire/outbox.h"

/// Frames over WebSockets, plain or with TLS: the door to Boost.Beast and OpenSSL.
namespace waymark::session::socket {

inline constexpr std::size_t kMaxFrameBytes = kMaxImageBytes + 64 * 1024;
inline constexpr std::size_t kMaxWaitingBytes = 16 * 1024 * 1024;  ///< of a peer that reads slowly

/// What a channel tells, one call at a time, on the loop's threads.
struct ChannelEvents {
  std::function<void(std::span<const std::uint8_t> frame)> on_frame;
  std::function<void(const Error& why)> on_end;  ///< the last call
};

/// One open WebSocket. Thread-safe. It lives while it is open or somebody holds it.
class Channel {
 public:
  virtual ~Channel() = default;

  /// Reads from now on; call it once.
  virtual void Start(ChannelEvents events) = 0;
  /// Queues a frame (see Outbox). When too much waits, the channel ends: a reader that slow is as
  /// good as gone.
  virtual void Send(wire::SharedFrame frame, std::optional<wire::Slot> slot) = 0;
  void Send(std::vector<std::uint8_t> frame, std::optional<wire::Slot> slot) {
    Send(wire::Share(std::move(frame)), slot);
  }
  /// Queues the parts of one large frame, which go when nothing else waits. What is left of an
  /// earlier one is not sent any more.
  virtual void SendParts(std::vector<wire::SharedFrame> parts) = 0;
  /// Bytes of those parts that have not gone yet.
  virtual std::size_t WaitingPartBytes() const = 0;
  /// Sends what waits, says goodbye and ends, all within a second.
  virtual void Close(std::string why) = 0;
  /// Ends at once.
  virtual void Abort() = 0;
  /// "203.0.113.5:4711"
  virtual const std::string& peer() const = 0;
};

/// PEM files; empty ones mean: no TLS (server), the system's authorities (client).
struct ServerTls {
  std::string certificate_chain_file, private_key_file;
};
struct ClientTls {
  std::string authority_file;
};

struct ListenOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: any free one
  ServerTls tls = {};
};

/// Takes connections until it is destroyed.
class Listener {
 public:
  virtual ~Listener() = default;
  virtual std::uint16_t port() const = 0;
};

/// Hands over each channel once its handshake is done; those that dawdle are dropped after 5 s.
/// Errors: InvalidArgument (address, certificate), Conflict (the port is taken), Unavailable.
Result<std::unique_ptr<Listener>> Listen(SocketLoop& loop, const ListenOptions& options,
                                         std::function<void(std::shared_ptr<Channel>)> on_channel);

struct ConnectOptions {
  std::string host;
  std::uint16_t port = 0;
  std::optional<ClientTls> tls = {};  ///< absent: plain
};

/// Connects in the background, within 5 s. Errors handed over: NotFound (host), Unavailable.
/// Errors returned: InvalidArgument (authorities).
Result<void> Connect(SocketLoop& loop, const ConnectOptions& options,
                     std::function<void(Result<std::shared_ptr<Channel>>)> on_done);

}  // namespace waymark::session::socket

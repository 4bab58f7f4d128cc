// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>

#include "mapping/base/log.h"
#include "session/socket/channel.h"
#include "session/socket/internal/socket_options.h"
#include "session/socket/internal/subprotocol.h"

namespace waymark::session::socket::internal {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::system::error_code;

using PlainStream = beast::tcp_stream;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

/// What a phone wants of its WebSocket. A peer that is silent for 8 s, although it was asked for a
/// sign of life, is gone.
template <typename Stream>
void Configure(websocket::stream<Stream>& stream) {
  auto timeouts = websocket::stream_base::timeout::suggested(beast::role_type::client);
  timeouts.handshake_timeout = std::chrono::seconds(5);
  timeouts.idle_timeout = std::chrono::seconds(8);
  timeouts.keep_alive_pings = true;
  stream.set_option(timeouts);
  stream.binary(true);
  stream.auto_fragment(false);
  stream.read_message_max(kMaxFrameBytes);
  const int descriptor = beast::get_lowest_layer(stream).socket().native_handle();
  SendAtOnce(descriptor);
  KeepLittleUnsent(descriptor);
}

/// A phone's end of a WebSocket. The handlers run on the stream's strand.
template <typename Stream>
class WebSocketChannel final : public Channel,
                               public std::enable_shared_from_this<WebSocketChannel<Stream>> {
 public:
  WebSocketChannel(websocket::stream<Stream> stream, std::string peer)
      : stream_(std::move(stream)), peer_(std::move(peer)) {}

  void Start(ChannelEvents events) override {
    OnStrand([events = std::move(events)](WebSocketChannel& self) mutable {
      self.events_ = std::move(events);
      if (!self.has_ended_) self.Read();
    });
  }

  void Send(wire::SharedFrame frame, std::optional<wire::Slot> slot) override {
    switch (outbox_.Push(std::move(frame), slot)) {
      case wire::Outbox::Outcome::kFirst:
        return OnStrand([](WebSocketChannel& self) { self.Write(); });
      case wire::Outbox::Outcome::kQueued:
        return;
      case wire::Outbox::Outcome::kFull:
        return OnStrand([](WebSocketChannel& self) {
          self.End(MakeError(ErrorCode::kUnavailable, "{}: reads too slowly", self.peer_));
        });
    }
  }

  void SendParts(std::vector<wire::SharedFrame> parts) override {
    if (!outbox_.PushParts(std::move(parts))) return;
    OnStrand([](WebSocketChannel& self) { self.Write(); });
  }

  std::size_t WaitingPartBytes() const override { return outbox_.WaitingPartBytes(); }

  void Close(std::string why) override {
    OnStrand([why = std::move(why)](WebSocketChannel& self) {
      self.is_closing_ = true;
      self.farewell_ = why.substr(0, 100);  // a close frame holds 123 octets
      beast::get_lowest_layer(self.stream_).expires_after(std::chrono::seconds(1));
      self.Write();
    });
  }

  void Abort() override {
    OnStrand([](WebSocketChannel& self) {
      self.End(MakeError(ErrorCode::kUnavailable, "{}: given up", self.peer_));
    });
  }

  const std::string& peer() const override { return peer_; }

 private:
  template <typename Task>
  void OnStrand(Task task) {
    asio::post(stream_.get_executor(), [self = this->shared_from_this(),
                                        task = std::move(task)]() mutable { task(*self); });
  }

  void Read() {
    stream_.async_read(
        incoming_, [self = this->shared_from_this()](error_code failure, std::size_t) {
          if (failure) return self->End(self->Explain(failure));
          const auto bytes = self->incoming_.data();
          if (!self->stream_.got_binary()) {
            return self->End(MakeError(ErrorCode::kCorrupt, "{}: sent text", self->peer_));
          }
          if (self->has_ended_) return;
          self->events_.on_frame({static_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
          self->incoming_.consume(self->incoming_.size());
          if (!self->has_ended_) self->Read();
        });
  }

  void Write() {
    if (is_writing_ || has_ended_) return;
    outgoing_ = outbox_.Pop();
    if (!outgoing_) return is_closing_ ? SayGoodbye() : void();
    is_writing_ = true;
    stream_.async_write(asio::buffer(*outgoing_),
                        [self = this->shared_from_this()](error_code failure, std::size_t) {
                          self->is_writing_ = false;
                          if (failure) return self->End(self->Explain(failure));
                          self->Write();
                        });
  }

  void SayGoodbye() {
    is_writing_ = true;
    stream_.async_close({websocket::close_code::normal, farewell_},
                        [self = this->shared_from_this()](error_code) {
                          self->End(MakeError(ErrorCode::kUnavailable, "{}: closed", self->peer_));
                        });
  }

  Error Explain(error_code failure) const {
    if (failure == websocket::error::closed) {
      const auto reason = stream_.reason();
      return MakeError(ErrorCode::kUnavailable, "{}: said goodbye: {}", peer_,
                       std::string_view(reason.reason.data(), reason.reason.size()));
    }
    return MakeError(ErrorCode::kUnavailable, "{}: {}", peer_, failure.message());
  }

  void End(const Error& why) {
    if (std::exchange(has_ended_, true)) return;
    outbox_.Clear();
    error_code ignored;
    beast::get_lowest_layer(stream_).socket().close(ignored);
    if (events_.on_end) events_.on_end(why);
    events_ = {};
  }

  websocket::stream<Stream> stream_;
  const std::string peer_;
  wire::Outbox outbox_{kMaxWaitingBytes};

  // Used on the strand alone.
  ChannelEvents events_;
  beast::flat_buffer incoming_;
  wire::SharedFrame outgoing_;  // being written
  std::string farewell_;
  bool is_writing_ = false;
  bool is_closing_ = false;
  bool has_ended_ = false;
};

}  // namespace waymark::session::socket::internal

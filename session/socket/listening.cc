// SPDX-License-Identifier: Apache-2.0
#include <boost/asio/strand.hpp>

#include "session/socket/internal/loop_impl.h"
#include "session/socket/internal/tls.h"
#include "session/socket/internal/websocket_channel.h"

namespace waymark::session::socket {
namespace {

using namespace internal;
using asio::ip::tcp;
using OnChannel = std::function<void(std::shared_ptr<Channel>)>;

constexpr std::chrono::seconds kHandshakeLimit{5};

/// A connection until it is a channel.
template <typename Stream>
class Arrival : public std::enable_shared_from_this<Arrival<Stream>> {
 public:
  Arrival(Stream stream, std::string peer, std::shared_ptr<asio::ssl::context> tls,
          const OnChannel& on_channel)
      : tls_(std::move(tls)),
        stream_(std::move(stream)),
        peer_(std::move(peer)),
        on_channel_(on_channel) {}

  void Begin() {
    beast::get_lowest_layer(stream_).expires_after(kHandshakeLimit);
    if constexpr (std::is_same_v<Stream, TlsStream>) {
      stream_.next_layer().async_handshake(asio::ssl::stream_base::server,
                                           [self = this->shared_from_this()](error_code failure) {
                                             if (failure) return self->Drop(failure);
                                             self->Upgrade();
                                           });
    } else {
      Upgrade();
    }
  }

 private:
  void Upgrade() {
    beast::get_lowest_layer(stream_).expires_never();  // from here on the WebSocket's own
    Configure(stream_, beast::role_type::server);
    stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(beast::http::field::sec_websocket_protocol, kSubprotocol);
    }));
    stream_.async_accept([self = this->shared_from_this()](error_code failure) {
      if (failure) return self->Drop(failure);
      self->on_channel_(
          std::make_shared<WebSocketChannel<Stream>>(std::move(self->stream_), self->peer_));
    });
  }

  void Drop(error_code failure) const {
    LogInfo("{}: handshake failed: {}", peer_, failure.message());
  }

  std::shared_ptr<asio::ssl::context> tls_;  // outlives the stream
  websocket::stream<Stream> stream_;
  std::string peer_;
  OnChannel on_channel_;
};

class TcpListener final : public Listener, public std::enable_shared_from_this<TcpListener> {
 public:
  TcpListener(asio::io_context& context, std::shared_ptr<asio::ssl::context> tls,
              OnChannel on_channel)
      : context_(context),
        acceptor_(asio::make_strand(context)),
        tls_(std::move(tls)),
        on_channel_(std::move(on_channel)) {}

  error_code Open(const tcp::endpoint& endpoint) {
    error_code failure;
    acceptor_.open(endpoint.protocol(), failure);
    if (!failure) acceptor_.set_option(asio::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(endpoint, failure);
    if (!failure) acceptor_.listen(asio::socket_base::max_listen_connections, failure);
    return failure;
  }

  std::uint16_t port() const override { return acceptor_.local_endpoint().port(); }

  void Accept() {
    acceptor_.async_accept(asio::make_strand(context_),
                           [self = shared_from_this()](error_code failure, tcp::socket socket) {
                             if (failure == asio::error::operation_aborted) return;
                             if (!failure) self->Welcome(std::move(socket));
                             self->Accept();
                           });
  }

  void Close() {
    asio::post(acceptor_.get_executor(), [self = shared_from_this()] {
      error_code ignored;
      self->acceptor_.close(ignored);
    });
  }

 private:
  void Welcome(tcp::socket socket) {
    error_code failure;
    const tcp::endpoint remote = socket.remote_endpoint(failure);
    if (failure) return;
    const std::string peer = fmt::format("{}:{}", remote.address().to_string(), remote.port());
    PlainStream stream(std::move(socket));
    if (tls_) {
      std::make_shared<Arrival<TlsStream>>(TlsStream(std::move(stream), *tls_), peer, tls_,
                                           on_channel_)
          ->Begin();
    } else {
      std::make_shared<Arrival<PlainStream>>(std::move(stream), peer, nullptr, on_channel_)
          ->Begin();
    }
  }

  asio::io_context& context_;
  tcp::acceptor acceptor_;
  std::shared_ptr<asio::ssl::context> tls_;
  OnChannel on_channel_;
};

/// Ends accepting when its owner lets go, though handlers may still hold the listener.
class ListenerHandle final : public Listener {
 public:
  explicit ListenerHandle(std::shared_ptr<TcpListener> listener)
      : listener_(std::move(listener)), port_(listener_->port()) {}
  ~ListenerHandle() override { listener_->Close(); }
  std::uint16_t port() const override { return port_; }

 private:
  std::shared_ptr<TcpListener> listener_;
  std::uint16_t port_;
};

}  // namespace

Result<std::unique_ptr<Listener>> Listen(SocketLoop& loop, const ListenOptions& options,
                                         OnChannel on_channel) {
  error_code failure;
  const auto address = asio::ip::make_address(options.address, failure);
  if (failure) {
    return MakeError(ErrorCode::kInvalidArgument, "listen: expected an IP address, found \"{}\"",
                     options.address);
  }
  std::shared_ptr<asio::ssl::context> tls;
  if (!options.tls.certificate_chain_file.empty()) {
    WAYMARK_TRY_ASSIGN(tls, MakeServerContext(options.tls));
  }
  auto listener =
      std::make_shared<TcpListener>(loop.impl().context, std::move(tls), std::move(on_channel));
  failure = listener->Open({address, options.port});
  if (failure) {
    return MakeError(
        failure == asio::error::address_in_use ? ErrorCode::kConflict : ErrorCode::kUnavailable,
        "{}:{}: cannot listen: {}", options.address, options.port, failure.message());
  }
  listener->Accept();
  return std::unique_ptr<Listener>(std::make_unique<ListenerHandle>(std::move(listener)));
}

}  // namespace waymark::session::socket

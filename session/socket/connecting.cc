// SPDX-License-Identifier: Apache-2.0
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/strand.hpp>

#include "session/socket/internal/loop_impl.h"
#include "session/socket/internal/tls.h"
#include "session/socket/internal/websocket_channel.h"

namespace waymark::session::socket {
namespace {

using namespace internal;
using asio::ip::tcp;
using OnDone = std::function<void(Result<std::shared_ptr<Channel>>)>;

constexpr std::chrono::seconds kConnectLimit{5};

/// One attempt to reach a gateway.
template <typename Stream>
class Attempt : public std::enable_shared_from_this<Attempt<Stream>> {
 public:
  Attempt(asio::io_context& context, Stream stream, const ConnectOptions& options,
          std::shared_ptr<asio::ssl::context> tls, OnDone on_done)
      : options_(options),
        peer_(fmt::format("{}:{}", options.host, options.port)),
        resolver_(context),
        tls_(std::move(tls)),
        stream_(std::move(stream)),
        on_done_(std::move(on_done)) {}

  void Begin() {
    resolver_.async_resolve(
        options_.host, std::to_string(options_.port),
        [self = this->shared_from_this()](error_code failure, tcp::resolver::results_type found) {
          if (failure) return self->Fail(ErrorCode::kNotFound, failure);
          auto& lowest = beast::get_lowest_layer(self->stream_);
          lowest.expires_after(kConnectLimit);
          lowest.async_connect(found, [self](error_code refusal, const tcp::endpoint&) {
            if (refusal) return self->Fail(ErrorCode::kUnavailable, refusal);
            self->Secure();
          });
        });
  }

 private:
  void Secure() {
    if constexpr (std::is_same_v<Stream, TlsStream>) {
      auto& tls = stream_.next_layer();
      tls.set_verify_callback(asio::ssl::host_name_verification(options_.host));
      SSL_set_tlsext_host_name(tls.native_handle(), options_.host.c_str());
      tls.async_handshake(asio::ssl::stream_base::client,
                          [self = this->shared_from_this()](error_code failure) {
                            if (failure) return self->Fail(ErrorCode::kUnavailable, failure);
                            self->Upgrade();
                          });
    } else {
      Upgrade();
    }
  }

  void Upgrade() {
    beast::get_lowest_layer(stream_).expires_never();  // from here on the WebSocket's own
    Configure(stream_);
    stream_.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
      request.set(beast::http::field::sec_websocket_protocol, kSubprotocol);
    }));
    stream_.async_handshake(peer_, "/", [self = this->shared_from_this()](error_code failure) {
      if (failure) return self->Fail(ErrorCode::kUnavailable, failure);
      self->on_done_(std::shared_ptr<Channel>(
          std::make_shared<WebSocketChannel<Stream>>(std::move(self->stream_), self->peer_)));
    });
  }

  void Fail(ErrorCode code, error_code failure) const {
    on_done_(MakeError(code, "{}: {}", peer_, failure.message()));
  }

  const ConnectOptions options_;
  const std::string peer_;
  tcp::resolver resolver_;
  std::shared_ptr<asio::ssl::context> tls_;  // outlives the stream
  websocket::stream<Stream> stream_;
  OnDone on_done_;
};

}  // namespace

Result<void> Connect(SocketLoop& loop, const ConnectOptions& options, OnDone on_done) {
  asio::io_context& context = loop.impl().context;
  PlainStream stream(asio::make_strand(context));
  if (!options.tls) {
    std::make_shared<Attempt<PlainStream>>(context, std::move(stream), options, nullptr,
                                           std::move(on_done))
        ->Begin();
    return {};
  }
  WAYMARK_TRY_ASSIGN(const auto tls, MakeClientContext(*options.tls));
  std::make_shared<Attempt<TlsStream>>(context, TlsStream(std::move(stream), *tls), options, tls,
                                       std::move(on_done))
      ->Begin();
  return {};
}

}  // namespace waymark::session::socket

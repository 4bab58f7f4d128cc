// SPDX-License-Identifier: Apache-2.0
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/strand.hpp>

#include "session/socket/internal/loop_impl.h"
#include "session/socket/internal/tls.h"

namespace waymark::session::socket {
namespace {

using namespace internal;
namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

class TcpListener final : public Listener, public std::enable_shared_from_this<TcpListener> {
 public:
  TcpListener(SocketLoop::Impl& loop, std::shared_ptr<asio::ssl::context> tls, OnChannel on_channel)
      : loop_(loop),
        acceptor_(asio::make_strand(loop.context)),
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
    acceptor_.async_accept([self = shared_from_this()](error_code failure, tcp::socket socket) {
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
  /// One carrier after the other takes a connection.
  void Welcome(tcp::socket socket) {
    error_code failure;
    const tcp::endpoint remote = socket.remote_endpoint(failure);
    if (!failure) socket.native_non_blocking(true, failure);
    if (failure) return;
    const auto& carrier = loop_.carriers[next_++ % loop_.carriers.size()];
    carrier->Carry(std::make_shared<ServedChannel>(
        Descriptor(socket.release()), tls_ ? tls_->native_handle() : nullptr,
        fmt::format("{}:{}", remote.address().to_string(), remote.port()), on_channel_, carrier));
  }

  SocketLoop::Impl& loop_;
  tcp::acceptor acceptor_;
  std::shared_ptr<asio::ssl::context> tls_;
  OnChannel on_channel_;
  std::size_t next_ = 0;
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
  WAYMARK_TRY(loop.impl().MakeCarriers());
  auto listener = std::make_shared<TcpListener>(loop.impl(), std::move(tls), std::move(on_channel));
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

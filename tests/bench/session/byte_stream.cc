// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/byte_stream.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace waymark::bench {
namespace {

SSL_CTX* TlsOfPhones() {
  static SSL_CTX* const context = ::SSL_CTX_new(TLS_client_method());
  return context;
}

}  // namespace

void ByteStream::Free::operator()(ssl_st* tls) const { ::SSL_free(tls); }

Result<ByteStream> ByteStream::Connect(std::uint16_t port, bool is_tls) {
  ByteStream stream(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  const auto fail = [&](const char* what) {
    return MakeError(ErrorCode::kUnavailable, "127.0.0.1:{}: {} failed: error {}", port, what,
                     errno);
  };
  if (::connect(stream.descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) !=
      0) {
    return fail("connecting");
  }
  const int no_delay = 1;
  ::setsockopt(stream.descriptor_, IPPROTO_TCP, TCP_NODELAY, &no_delay, sizeof no_delay);
  if (!is_tls) return stream;
  stream.tls_.reset(::SSL_new(TlsOfPhones()));
  ::SSL_set_fd(stream.tls_.get(), stream.descriptor_);
  if (::SSL_connect(stream.tls_.get()) != 1) return fail("the handshake of TLS");
  return stream;
}

ByteStream::ByteStream(ByteStream&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), tls_(std::move(other.tls_)) {}

ByteStream& ByteStream::operator=(ByteStream&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  tls_.swap(other.tls_);
  return *this;
}

ByteStream::~ByteStream() {
  tls_.reset();
  if (descriptor_ >= 0) ::close(descriptor_);
}

void ByteStream::SetNonBlocking() { ::fcntl(descriptor_, F_SETFL, O_NONBLOCK); }

bool ByteStream::Send(std::span<const std::uint8_t> bytes) {
  const auto size = static_cast<ssize_t>(bytes.size());
  if (!tls_) return ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == size;
  return ::SSL_write(tls_.get(), bytes.data(), static_cast<int>(size)) == size;
}

ssize_t ByteStream::Receive(std::span<std::uint8_t> buffer) {
  if (!tls_) {
    const ssize_t count = ::recv(descriptor_, buffer.data(), buffer.size(), 0);
    return count < 0 && errno != EAGAIN && errno != EINTR ? 0 : count;
  }
  const int count = ::SSL_read(tls_.get(), buffer.data(), static_cast<int>(buffer.size()));
  if (count > 0) return count;
  return ::SSL_get_error(tls_.get(), count) == SSL_ERROR_WANT_READ ? -1 : 0;
}

}  // namespace waymark::bench

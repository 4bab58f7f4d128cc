// SPDX-License-Identifier: Apache-2.0
#include "session/socket/internal/byte_stream.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>

namespace waymark::session::socket::internal {
namespace {

class PlainBytes final : public ByteStream {
 public:
  explicit PlainBytes(int descriptor) : descriptor_(descriptor) {}

  Result<bool> ShakeHands() override { return true; }

  Result<std::size_t> Read(std::span<std::uint8_t> bytes) override {
    const ssize_t count = ::recv(descriptor_, bytes.data(), bytes.size(), 0);
    if (count == 0) return MakeError(ErrorCode::kUnavailable, "the connection was closed");
    return Count(count);
  }

  Result<std::size_t> Write(std::span<const std::uint8_t> bytes) override {
    return Count(::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL));
  }

 private:
  static Result<std::size_t> Count(ssize_t count) {
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) return std::size_t{0};
    return MakeError(ErrorCode::kUnavailable, "{}", std::strerror(errno));
  }

  int descriptor_;
};

struct SslDeleter {
  void operator()(SSL* ssl) const { SSL_free(ssl); }
};

class TlsBytes final : public ByteStream {
 public:
  TlsBytes(int descriptor, SSL_CTX* context) : ssl_(SSL_new(context)) {
    CHECK(ssl_ != nullptr && SSL_set_fd(ssl_.get(), descriptor) == 1, "no memory for TLS");
    SSL_set_read_ahead(ssl_.get(), 1);  // a record's head and body in one call
    SSL_set_mode(ssl_.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                                 SSL_MODE_RELEASE_BUFFERS);
  }

  Result<bool> ShakeHands() override {
    ERR_clear_error();
    const int outcome = SSL_accept(ssl_.get());
    if (outcome == 1) return true;
    if (IsPatient(outcome)) return false;
    return MakeError(ErrorCode::kUnavailable, "TLS: {}", Reason());
  }

  Result<std::size_t> Read(std::span<std::uint8_t> bytes) override {
    std::size_t count = 0;
    while (count < bytes.size()) {
      ERR_clear_error();
      std::size_t read = 0;
      const int outcome =
          SSL_read_ex(ssl_.get(), bytes.data() + count, bytes.size() - count, &read);
      count += read;
      if (outcome == 1 && SSL_has_pending(ssl_.get()) == 1) continue;
      if (outcome == 1) break;  // asking the socket again would cost as much as the record did
      if (IsPatient(outcome) || count > 0) break;  // an end is told when nothing is before it
      return MakeError(ErrorCode::kUnavailable, "TLS: {}", Reason());
    }
    return count;
  }

  Result<std::size_t> Write(std::span<const std::uint8_t> bytes) override {
    ERR_clear_error();
    std::size_t count = 0;
    const int outcome = SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &count);
    if (outcome == 1) return count;
    if (IsPatient(outcome)) return std::size_t{0};
    return MakeError(ErrorCode::kUnavailable, "TLS: {}", Reason());
  }

 private:
  bool IsPatient(int outcome) const {
    const int error = SSL_get_error(ssl_.get(), outcome);
    return error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE;
  }

  static const char* Reason() {
    const char* const reason = ERR_reason_error_string(ERR_peek_last_error());
    return reason == nullptr ? "the connection was closed" : reason;
  }

  std::unique_ptr<SSL, SslDeleter> ssl_;
};

}  // namespace

std::unique_ptr<ByteStream> MakePlainStream(int descriptor) {
  return std::make_unique<PlainBytes>(descriptor);
}

std::unique_ptr<ByteStream> MakeTlsStream(int descriptor, SSL_CTX* context) {
  return std::make_unique<TlsBytes>(descriptor, context);
}

}  // namespace waymark::session::socket::internal

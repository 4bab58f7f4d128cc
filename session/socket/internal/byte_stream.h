// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openssl/types.h>

#include <cstdint>
#include <memory>
#include <span>

#include "mapping/base/result.h"

namespace waymark::session::socket::internal {

/// The bytes of a connected socket, plain or within TLS. Nothing waits. Thread-compatible.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  /// Whether bytes can go; call it whenever something came until they can.
  /// Errors: Unavailable (the other speaks no TLS, or another).
  virtual Result<bool> ShakeHands() = 0;
  /// How many octets were read; when fewer than there is room for, no more are there now.
  /// Errors: Unavailable (the connection ended).
  virtual Result<std::size_t> Read(std::span<std::uint8_t> bytes) = 0;
  /// How many octets were taken; those that were not must come first the next time.
  /// Errors: Unavailable (the connection ended).
  virtual Result<std::size_t> Write(std::span<const std::uint8_t> bytes) = 0;
};

/// Of a socket that does not block and outlives the stream.
std::unique_ptr<ByteStream> MakePlainStream(int descriptor);
std::unique_ptr<ByteStream> MakeTlsStream(int descriptor, SSL_CTX* context);

}  // namespace waymark::session::socket::internal

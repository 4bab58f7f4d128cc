// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <span>

#include "mapping/base/result.h"

struct ssl_st;

namespace waymark::bench {

/// A TCP connection to this machine, in clear or under TLS, whose certificate nobody asks about:
/// what it costs is measured, not whom it trusts. Thread-compatible.
class ByteStream {
 public:
  /// Waits until both ends are ready. Errors: Unavailable.
  static Result<ByteStream> Connect(std::uint16_t port, bool is_tls);
  ByteStream(ByteStream&& other) noexcept;
  ByteStream& operator=(ByteStream&& other) noexcept;
  ~ByteStream();

  int descriptor() const { return descriptor_; }
  /// From now on nothing waits.
  void SetNonBlocking();
  /// Sends all of it or nothing; says whether it was sent. `bytes` are far fewer than the socket
  /// holds.
  bool Send(std::span<const std::uint8_t> bytes);
  /// What is there, at most a buffer full of 16 KiB and more; -1: nothing yet, 0: it is over.
  ssize_t Receive(std::span<std::uint8_t> buffer);

 private:
  struct Free {
    void operator()(ssl_st* tls) const;
  };

  explicit ByteStream(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
  std::unique_ptr<ssl_st, Free> tls_;  // null: in clear
};

}  // namespace waymark::bench

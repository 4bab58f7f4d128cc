// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace waymark::session::socket::internal {

/// Small messages do not wait for each other.
inline void SendAtOnce(int descriptor) {
  constexpr int kYes = 1;
  (void)::setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &kYes, sizeof kYes);
}

/// What has been handed to the kernel can neither be overtaken nor taken back, so it shall hold
/// little that it cannot send yet. Systems without the option work, only later.
inline void KeepLittleUnsent(int descriptor) {
#ifdef TCP_NOTSENT_LOWAT
  constexpr int kUnsentBytes = 4096;
  (void)::setsockopt(descriptor, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentBytes,
                     sizeof kUnsentBytes);
#endif
}

}  // namespace waymark::session::socket::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <csignal>
#include <ctime>

namespace waymark::session {

/// Blocks SIGINT and SIGTERM. To be called before any thread starts, so that none of them is
/// interrupted and AwaitSignal sees the signals.
inline sigset_t BlockEndSignals() {
  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGINT);
  ::sigaddset(&signals, SIGTERM);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

/// Calls `each` at once and every hour until a signal comes.
template <typename Each>
void AwaitSignal(const sigset_t& signals, const Each& each) {
  constexpr timespec kHour{.tv_sec = 3600, .tv_nsec = 0};
  do {
    each();
  } while (::sigtimedwait(&signals, nullptr, &kHour) < 0);
}

}  // namespace waymark::session

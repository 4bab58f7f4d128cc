// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>

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

inline void AwaitSignal(const sigset_t& signals) {
  int signal = 0;
  ::sigwait(&signals, &signal);
}

}  // namespace waymark::session

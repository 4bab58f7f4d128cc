// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/interruption.h"

#include <unistd.h>

#include <csignal>
#include <string_view>

namespace waymark::mapping {
namespace {

volatile std::sig_atomic_t interrupted = 0;  // the one global: a signal handler has no other way

extern "C" void OnInterruption(int signal) {
  interrupted = 1;
  constexpr std::string_view kMessage =
      "\nwaymark-map: stopping after the current step; once more stops at once\n";
  [[maybe_unused]] const auto ignored = write(STDERR_FILENO, kMessage.data(), kMessage.size());
  std::signal(signal, SIG_DFL);
}

}  // namespace

void CatchInterruption() {
  std::signal(SIGINT, OnInterruption);
  std::signal(SIGTERM, OnInterruption);
}

bool WasInterrupted() { return interrupted != 0; }

}  // namespace waymark::mapping

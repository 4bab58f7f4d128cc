// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/churn.h"

#include <fmt/format.h>

#include "tests/bench/session/crowd.h"

namespace waymark::bench {

Result<void> MeasureChurn(const Child& server, const Child& gateway, std::uint16_t port,
                          const ChurnOptions& options) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const double sample_s = std::max(2.0, options.seconds / 20);
  std::uint64_t phones = 0;
  int samples = 0;
  fmt::print("{:>6} {:>7} {:>11} {:>12} {:>12} {:>13}\n", "s", "phones", "server MiB",
             "gateway MiB", "server files", "gateway files");
  for (double now_s = 0; now_s < options.seconds; now_s = Seconds(Clock::now() - begin)) {
    if (now_s >= sample_s * samples) {
      ++samples;
      fmt::print("{:>6.0f} {:>7} {:>11.1f} {:>12.1f} {:>12} {:>13}\n", now_s, phones,
                 server.MemoryMib(), gateway.MemoryMib(), server.Descriptors(),
                 gateway.Descriptors());
      std::fflush(stdout);
    }
    // In a room of their own: who died keeps its seat for a minute.
    WAYMARK_TRY_ASSIGN(const auto crowd,
                       Crowd::Connect(port, {.phones = options.phones,
                                             .per_room = static_cast<std::uint64_t>(options.phones),
                                             .first_phone = phones}));
    WAYMARK_TRY(crowd->JoinAll());
    (void)crowd->Walk(options.walk_s);
    phones += static_cast<std::uint64_t>(options.phones);
  }
  return {};
}

}  // namespace waymark::bench

// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/swap.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <thread>

#include "tests/bench/session/child.h"
#include "tests/bench/session/crowd.h"

namespace waymark::bench {
namespace {

/// Between two poses that a phone heard: when the server sent them, and when they came.
struct Gaps {
  double sent_ms = 0, heard_ms = 0;
};

Gaps LongestGaps(const std::vector<Heard>& phones) {
  Gaps longest;
  for (const Heard& phone : phones) {
    for (std::size_t i = 1; i < phone.sent.size(); ++i) {
      const double sent_ms = 1e3 * Seconds(phone.sent[i] - phone.sent[i - 1]);
      const double heard_ms = sent_ms + static_cast<double>(phone.legs_ms[i]) -
                              static_cast<double>(phone.legs_ms[i - 1]);
      longest = {std::max(longest.sent_ms, sent_ms), std::max(longest.heard_ms, heard_ms)};
    }
  }
  return longest;
}

double Since(ServerTime begin, const std::optional<ServerTime>& end) {
  return end ? Seconds(*end - begin) : NAN;
}

struct Measured {
  double wait_ms = 0;
  Gaps gaps;
  double over_s = 0, anchors_s = 0, server_s = 0;
  std::uint64_t anchors = 0;
};

/// One swap under a crowd that walks.
Measured MeasureSwap(const Child& server, Crowd& crowd, double seconds) {
  ServerTime begin;
  double cpu_s = 0;
  std::thread swapping([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    begin = Now();
    cpu_s = server.CpuS();
    server.Signal(SIGUSR1);
  });
  const Walked walked = crowd.Walk(seconds);
  swapping.join();
  return {.wait_ms = walked.longest_wait_ms,
          .gaps = LongestGaps(walked.heard),
          .over_s = Since(begin, walked.swap.last_over),
          .anchors_s = Since(begin, walked.swap.last_anchor),
          .server_s = server.CpuS() - cpu_s,
          .anchors = walked.swap.anchors};
}

void Worsen(Measured& worst, const Measured& next) {
  const auto worsen = [](double& a, double b) { a = std::max(a, b); };
  worsen(worst.wait_ms, next.wait_ms);
  worsen(worst.gaps.sent_ms, next.gaps.sent_ms);
  worsen(worst.gaps.heard_ms, next.gaps.heard_ms);
  worsen(worst.over_s, next.over_s);
  worsen(worst.anchors_s, next.anchors_s);
  worsen(worst.server_s, next.server_s);
  worst.anchors = std::max(worst.anchors, next.anchors);
}

}  // namespace

Result<void> MeasureSwaps(const SwapOptions& options) {
  fmt::print("{:>8} {:>9} {:>9} {:>10} {:>7} {:>9} {:>7} {:>9} {:>10} {:>10} {:>8} {:>8}\n",
             "anchors", "wait ms", "sent ms", "heard ms", "over s", "anchors s", "told", "server s",
             "MiB before", "MiB opened", "MiB then", "B/anchor");
  for (const int anchors : options.anchors) {
    WAYMARK_TRY_ASSIGN(const Child server,
                       Child::Start({"server", fmt::format("--anchors={}", anchors),
                                     fmt::format("--city={}", options.city_m)}));
    const double before_mib = server.MemoryMib();
    WAYMARK_TRY_ASSIGN(const Child gateway, Child::Start({"gateway", server.line()}));
    WAYMARK_TRY_ASSIGN(const auto crowd,
                       Crowd::Connect(static_cast<std::uint16_t>(std::stoi(gateway.line())),
                                      {.phones = options.phones,
                                       .edge_m = options.city_m,
                                       .area_radius_m = options.anchor_radius_m}));
    WAYMARK_TRY(crowd->JoinAll());
    const double seconds = 4 + anchors / 15'000.0;
    (void)crowd->Walk(seconds);  // all is told of the areas
    const double opened_mib = server.MemoryMib();
    Measured worst;
    for (int i = 0; i < options.swaps; ++i) Worsen(worst, MeasureSwap(server, *crowd, seconds));
    const double then_mib = server.MemoryMib();
    fmt::print(
        "{:>8} {:>9.1f} {:>9.1f} {:>10.1f} {:>7.2f} {:>9.2f} {:>7} {:>9.2f} {:>10.0f} {:>10.0f} "
        "{:>8.0f} {:>8.0f}\n",
        anchors, worst.wait_ms, worst.gaps.sent_ms, worst.gaps.heard_ms, worst.over_s,
        worst.anchors_s, worst.anchors, worst.server_s, before_mib, opened_mib, then_mib,
        (then_mib - before_mib) * (1 << 20) / anchors);
    std::fflush(stdout);
    if (crowd->Lost() > 0) fmt::print("{} connections ended\n", crowd->Lost());
  }
  return {};
}

}  // namespace waymark::bench

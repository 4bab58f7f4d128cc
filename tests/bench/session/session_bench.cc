// SPDX-License-Identifier: Apache-2.0
// What a crowd costs: server, gateway and phones in three processes on this machine.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/bench/session/child.h"
#include "tests/bench/session/crowd.h"
#include "tests/session/session_fixture.h"
#include "tests/support/memory_anchor_store.h"

namespace waymark::bench {
namespace {

struct Flags {
  std::vector<int> phones{10, 30, 100, 300, 1000};
  int per_room = 20;
  double seconds = 10;
  double hz = 30;
};

/// SIGTERM ends it as it ends any process.
int StayUntilTold() {
  while (true) ::pause();
}

int RunServer() {
  session::ServerOptions options{.dds_domain = -1};
  const auto server = session::support::StartOnFreeDomain(options, [&] {
    return session::support::MakeParts(session::support::MakeRelease(),
                                       std::make_unique<waymark::support::MemoryAnchorStore>());
  });
  if (!server) return 1;
  fmt::print("{}\n", options.dds_domain);
  std::fflush(stdout);
  return StayUntilTold();
}

int RunGateway(int domain) {
  const auto gateway = session::Gateway::Start({.dds = {.domain = domain}});
  if (!gateway) return 1;
  fmt::print("{}\n", (*gateway)->port());
  std::fflush(stdout);
  return StayUntilTold();
}

float Quantile(std::vector<float>& values, double share) {
  if (values.empty()) return NAN;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct Summary {
  double delivered = 0;  ///< share of ticks that came with a batch
  double kB_per_s = 0;   ///< to a phone
  std::vector<float> latencies_ms;
};

Summary Summarise(std::vector<Heard> heard, double seconds) {
  Summary summary;
  std::uint32_t first = UINT32_MAX, last = 0;
  for (const Heard& phone : heard) {
    if (phone.ticks.empty()) continue;
    first = std::min(first, *phone.ticks.begin());
    last = std::max(last, *phone.ticks.rbegin());
  }
  double ticks = 0, bytes = 0;
  for (Heard& phone : heard) {
    ticks += static_cast<double>(phone.ticks.size());
    bytes += static_cast<double>(phone.bytes);
    summary.latencies_ms.insert(summary.latencies_ms.end(), phone.latencies_ms.begin(),
                                phone.latencies_ms.end());
  }
  const auto count = static_cast<double>(heard.size());
  summary.delivered = last >= first ? ticks / count / (last - first + 1.0) : 0;
  summary.kB_per_s = bytes / count / seconds / 1e3;
  return summary;
}

Result<void> Measure(int phones, const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const Child server, Child::Start({"server"}));
  WAYMARK_TRY_ASSIGN(const Child gateway, Child::Start({"gateway", server.line()}));
  Crowd crowd(static_cast<std::uint16_t>(std::stoi(gateway.line())), phones,
              std::min(flags.per_room, phones));
  const double join_s = crowd.JoinAll();
  if (join_s < 0) {
    return MakeError(ErrorCode::kTimeout, "{} phones: not all were welcome after a minute", phones);
  }
  const double server_s = server.CpuS(), gateway_s = gateway.CpuS(), own_s = OwnCpuS();
  const auto begin = std::chrono::steady_clock::now();
  Summary summary = Summarise(crowd.Walk(flags.hz, flags.seconds), flags.seconds);
  const double wall_s = Seconds(std::chrono::steady_clock::now() - begin);
  fmt::print(
      "{:>6} {:>6} {:>7.2f} {:>9.2f} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.2f} {:>8.2f} "
      "{:>8.0f} {:>8.0f}\n",
      phones, std::min(flags.per_room, phones), join_s, 100 * summary.delivered,
      Quantile(summary.latencies_ms, 0.5), Quantile(summary.latencies_ms, 0.99), summary.kB_per_s,
      100 * (server.CpuS() - server_s) / wall_s, 100 * (gateway.CpuS() - gateway_s) / wall_s,
      100 * (OwnCpuS() - own_s) / wall_s, server.MemoryMib(), gateway.MemoryMib());
  std::fflush(stdout);
  return {};
}

int Run(const Flags& flags) {
  fmt::print(
      "phones at {} Hz through a gateway; latency from a report to another phone's hearing it\n"
      "{:>6} {:>6} {:>7} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}\n"
      "{:>6} {:>6} {:>7} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}\n",
      flags.hz, "phones", "a room", "join s", "ticks", "p50", "p99", "kB/s", "server", "gateway",
      "phones", "server", "gateway", "", "", "", "heard %", "ms", "ms", "a phone", "% core",
      "% core", "% core", "MiB", "MiB");
  for (const int phones : flags.phones) {
    if (const auto measured = Measure(phones, flags); !measured) {
      fmt::print("{}\n", ToString(measured.error()));
    }
  }
  return 0;
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) {
  using namespace waymark::bench;
  CLI::App app("Phones that walk and listen through a gateway: latency, bytes and processor time.",
               "session_bench");
  Flags flags;
  app.add_option("--phones", flags.phones, "how many, each a measurement")->capture_default_str();
  app.add_option("--per-room", flags.per_room, "who hears each other")->capture_default_str();
  app.add_option("--seconds", flags.seconds, "of each measurement")->capture_default_str();
  app.add_option("--hz", flags.hz, "pose reports of a phone")->capture_default_str();
  int domain = 0, outcome = -1;
  app.add_subcommand("server", "")->group("")->callback([&] { outcome = RunServer(); });
  CLI::App* const gateway = app.add_subcommand("gateway", "")->group("");
  gateway->add_option("DOMAIN", domain)->required();
  gateway->callback([&] { outcome = RunGateway(domain); });
  CLI11_PARSE(app, argc, argv);
  return outcome >= 0 ? outcome : Run(flags);
}

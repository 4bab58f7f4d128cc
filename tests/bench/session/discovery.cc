// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "mapping/base/time.h"
#include "tests/bench/session/child.h"
#include "tests/bench/session/processes.h"

namespace waymark::bench {
namespace {

using std::chrono::milliseconds;

Result<double> LoopbackKilobytes() {
  std::ifstream file("/proc/net/dev");
  for (std::string name; file >> name;) {
    double bytes = 0;
    if (name == "lo:" && file >> bytes) return bytes / 1e3;
  }
  return MakeError(ErrorCode::kNotFound, "/proc/net/dev: no loopback interface");
}

/// Until what was begun has come to rest.
Result<double> Settled() {
  WAYMARK_TRY_ASSIGN(double before, LoopbackKilobytes());
  while (true) {
    std::this_thread::sleep_for(milliseconds(500));
    WAYMARK_TRY_ASSIGN(const double now, LoopbackKilobytes());
    if (now - before < 0.02 * now) return now;
    before = now;
  }
}

struct Cost {
  int devices;
  double found_kb, joined_kb, idle_kbps;  // of each
  double join_s;
  double server_mib;
};

/// Each process has at most so many of them, lest it run out of files that Cyclone can wait for.
constexpr int kPerProcess = 50;

Result<void> AwaitAll(const std::vector<Child>& processes, std::string_view word) {
  for (const Child& process : processes) {
    std::string line = process.line();
    while (line != word) {
      WAYMARK_TRY_ASSIGN(line, process.NextLine());
    }
  }
  return {};
}

Result<Cost> Measure(int devices, int slices) {
  const std::string cut = fmt::format("--slices={}", slices);
  WAYMARK_TRY_ASSIGN(const Child server, Child::Start({"server", cut}));
  WAYMARK_TRY_ASSIGN(const double begin, LoopbackKilobytes());
  std::vector<Child> processes;
  for (int first = 0; first < devices; first += kPerProcess) {
    const int count = std::min(kPerProcess, devices - first);
    WAYMARK_TRY_ASSIGN(Child process, Child::Start({"devices", server.line(), std::to_string(count),
                                                    std::to_string(first), cut}));
    processes.push_back(std::move(process));
  }
  WAYMARK_TRY(AwaitAll(processes, kDevicesAreMade));
  WAYMARK_TRY_ASSIGN(const double found, Settled());
  const auto at_join = std::chrono::steady_clock::now();
  for (const Child& process : processes) process.Signal(SIGUSR1);
  WAYMARK_TRY(AwaitAll(processes, kDevicesHaveJoined));
  const double join_s = Seconds(std::chrono::steady_clock::now() - at_join);
  std::this_thread::sleep_for(milliseconds(1000));
  WAYMARK_TRY_ASSIGN(const double joined, LoopbackKilobytes());
  std::this_thread::sleep_for(milliseconds(3000));
  WAYMARK_TRY_ASSIGN(const double idle, LoopbackKilobytes());
  return Cost{
      devices, (found - begin) / devices, (joined - found) / devices, (idle - joined) / 3 / devices,
      join_s,  server.MemoryMib()};
}

}  // namespace

Result<void> MeasureDiscovery(const std::vector<int>& devices, int slices) {
  fmt::print("{:>8} {:>22} {:>22} {:>16} {:>14} {:>16}\n", "devices", "until found, kB each",
             "until joined, kB each", "then, kB/s each", "joined in, s", "server, MiB");
  for (const int count : devices) {
    WAYMARK_TRY_ASSIGN(const Cost cost, Measure(count, slices));
    fmt::print("{:>8} {:>22.1f} {:>22.1f} {:>16.2f} {:>14.1f} {:>16.0f}\n", count, cost.found_kb,
               cost.joined_kb, cost.idle_kbps, cost.join_s, cost.server_mib);
    std::fflush(stdout);
  }
  return {};
}

}  // namespace waymark::bench

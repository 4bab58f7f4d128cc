// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/discovery.h"

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "tests/bench/session/bus_crowd.h"
#include "tests/bench/session/child.h"

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
};

Result<Cost> Measure(int devices) {
  WAYMARK_TRY_ASSIGN(const Child server, Child::Start({"server"}));
  WAYMARK_TRY_ASSIGN(const double begin, LoopbackKilobytes());
  WAYMARK_TRY_ASSIGN(const auto crowd, BusCrowd::Connect(std::stoi(server.line()), devices, 20, 1));
  WAYMARK_TRY_ASSIGN(const double found, Settled());
  WAYMARK_TRY(crowd->JoinAll());
  std::this_thread::sleep_for(milliseconds(1000));
  WAYMARK_TRY_ASSIGN(const double joined, LoopbackKilobytes());
  WAYMARK_TRY(crowd->JoinAll());  // says that they are here
  std::this_thread::sleep_for(milliseconds(2000));
  WAYMARK_TRY_ASSIGN(const double idle, LoopbackKilobytes());
  return Cost{devices, (found - begin) / devices, (joined - found) / devices,
              (idle - joined) / 2 / devices};
}

/// Least squares of a + b n at another n.
double Extrapolate(const std::vector<Cost>& costs, double Cost::*figure, double devices) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const Cost& cost : costs) {
    const double at = cost.devices, value = cost.*figure;
    n += 1, x += at, y += value, xx += at * at, xy += at * value;
  }
  const double slope = (n * xy - x * y) / (n * xx - x * x);
  return (y - slope * x) / n + slope * devices;
}

}  // namespace

Result<void> MeasureDiscovery(const std::vector<int>& devices) {
  fmt::print("{:>8} {:>22} {:>22} {:>22}\n", "devices", "until found, kB each",
             "until joined, kB each", "then, kB/s each");
  const auto print = [](const std::string& name, double found, double joined, double idle) {
    fmt::print("{:>8} {:>22.1f} {:>22.1f} {:>22.2f}\n", name, found, joined, idle);
    std::fflush(stdout);
  };
  std::vector<Cost> costs;
  for (const int count : devices) {
    WAYMARK_TRY_ASSIGN(const Cost cost, Measure(count));
    costs.push_back(cost);
    print(std::to_string(count), cost.found_kb, cost.joined_kb, cost.idle_kbps);
  }
  if (costs.size() < 2) return {};
  const auto at = [&](double Cost::*figure) { return Extrapolate(costs, figure, 1000); };
  print("1,000", at(&Cost::found_kb), at(&Cost::joined_kb), at(&Cost::idle_kbps));
  fmt::print("the last line continues straight lines through those before\n");
  return {};
}

}  // namespace waymark::bench

// SPDX-License-Identifier: Apache-2.0
// What a crowd costs: server, gateway and phones in three processes on this machine.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <string>
#include <thread>

#include "mapping/base/quantile.h"
#include "session/server/server.h"
#include "tests/bench/session/apps.h"
#include "tests/bench/session/bus_crowd.h"
#include "tests/bench/session/child.h"
#include "tests/bench/session/churn.h"
#include "tests/bench/session/crowd.h"
#include "tests/bench/session/discovery.h"
#include "tests/bench/session/peers/peers.h"
#include "tests/bench/session/processes.h"
#include "tests/bench/session/summary.h"

namespace waymark::bench {
namespace {

struct Flags {
  std::vector<std::string> layouts{"city", "square"};
  std::vector<int> phones{10, 30, 100, 300, 1000};
  int per_room = 20;
  int bus_phones = 200;
  double city_m = 3000;
  double square_m = 50;
  double seconds = 8;
  double hz = 30;
  int churn_phones = 100;
  int joins = 20;
  int anchors = 200;
  std::string csv, plot;
};

std::uint16_t PortOf(const Child& gateway) {
  return static_cast<std::uint16_t>(std::stoi(gateway.line()));
}

/// Lets a crowd walk and says what it cost meanwhile.
template <typename Walk>
void Observe(const Child& server, const Child* gateway, const Walk& walk, Row& row) {
  const double server_s = server.CpuS(), gateway_s = gateway ? gateway->CpuS() : 0;
  const double own_s = OwnCpuS();
  const auto begin = std::chrono::steady_clock::now();
  const Walked walked = walk();
  const double wall_s = Seconds(std::chrono::steady_clock::now() - begin);
  row.server_cores = (server.CpuS() - server_s) / wall_s;
  row.gateway_cores = gateway ? (gateway->CpuS() - gateway_s) / wall_s : 0;
  row.generator_cores = (OwnCpuS() - own_s) / wall_s;
  row.server_mib = server.MemoryMib();
  row.gateway_mib = gateway ? gateway->MemoryMib() : 0;
  Summarise(walked, session::ServerOptions().frame_hz, row);
}

/// So near that everybody is told of everybody at every tick.
constexpr double kCloseRoom_m = 5;

Result<Row> MeasureGateway(const std::string& layout, int phones, const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const Child server, Child::Start({"server"}));
  WAYMARK_TRY_ASSIGN(const Child gateway, Child::Start({"gateway", server.line()}));
  Crowd::Options options{.phones = phones, .hz = flags.hz};
  options.edge_m = layout == "city" ? flags.city_m : flags.square_m;
  if (layout == "rooms" || layout == "peers")
    options.per_room = static_cast<std::uint64_t>(flags.per_room);
  if (layout == "peers") options.edge_m = kCloseRoom_m;
  WAYMARK_TRY_ASSIGN(const auto crowd, Crowd::Connect(PortOf(gateway), options));
  Row row{.layout = layout, .phones = phones};
  WAYMARK_TRY_ASSIGN(row.join_s, crowd->JoinAll());
  Observe(
      server, &gateway, [&] { return crowd->Walk(flags.seconds); }, row);
  if (crowd->Lost() > 0) fmt::print("{} connections ended\n", crowd->Lost());
  return row;
}

Result<Row> MeasureBus(int phones, const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const Child server, Child::Start({"server"}));
  constexpr int kCells = 20;
  WAYMARK_TRY_ASSIGN(const auto crowd, BusCrowd::Connect(std::stoi(server.line()), phones, kCells));
  Row row{.layout = "bus", .phones = phones};
  WAYMARK_TRY_ASSIGN(row.join_s, crowd->JoinAll());
  Observe(
      server, nullptr, [&] { return crowd->Walk(flags.hz, flags.seconds); }, row);
  return row;
}

/// Apps join a room in which a hundred phones walk, on both ways.
Result<void> MeasureAppTimes(const Flags& flags) {
  constexpr int kOthers = 100;
  for (const bool is_direct : {false, true}) {
    WAYMARK_TRY_ASSIGN(const Child server, Child::Start({"server"}));
    WAYMARK_TRY_ASSIGN(const Child gateway, Child::Start({"gateway", server.line()}));
    WAYMARK_TRY_ASSIGN(
        const auto crowd,
        Crowd::Connect(PortOf(gateway), {.phones = kOthers, .edge_m = flags.square_m}));
    WAYMARK_TRY(crowd->JoinAll());
    std::atomic<bool> is_over = false;
    std::thread walking([&] {
      while (!is_over) (void)crowd->Walk(0.1);
    });
    const auto times =
        MeasureApps(is_direct ? "127.0.0.1" : fmt::format("ws://127.0.0.1:{}", gateway.line()),
                    std::stoi(server.line()), "room0", kOthers, flags.joins, flags.anchors);
    is_over = true;
    walking.join();
    if (!times) return times.error();
    fmt::print(
        "apps {}, beside {} phones: late join p50 {:.0f}, p99 {:.0f} ms ({} times); acknowledged "
        "anchor to another phone p50 {:.1f}, p99 {:.1f} ms ({} times)\n",
        is_direct ? "on the bus" : "through a gateway", kOthers,
        Quantile(times->joins_ms, 0.5, NAN), Quantile(times->joins_ms, 0.99, NAN), flags.joins,
        Quantile(times->anchors_ms, 0.5, NAN), Quantile(times->anchors_ms, 0.99, NAN),
        flags.anchors);
  }
  return {};
}

/// Our own way first, then the others'.
Result<void> MeasureAllPeers(const Flags& flags) {
  std::vector<PeerRow> ours;
  for (const int phones : flags.phones) {
    WAYMARK_TRY_ASSIGN(const Row row, MeasureGateway("peers", phones, flags));
    ours.push_back({.way = "gateway and server",
                    .phones = phones,
                    .poses_per_s = row.poses_per_s * phones,
                    .share = row.poses_per_s / (flags.hz * (flags.per_room - 1)),
                    .age_p50_ms = row.age_p50_ms,
                    .age_p99_ms = row.age_p99_ms,
                    .broker_cores = row.server_cores + row.gateway_cores,
                    .phones_cores = row.generator_cores});
  }
  return MeasurePeers({.phones = flags.phones,
                       .per_room = flags.per_room,
                       .hz = flags.hz,
                       .seconds = flags.seconds},
                      ours);
}

Result<void> MeasureChurnOfGateway(const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const Child server, Child::Start({"server"}));
  WAYMARK_TRY_ASSIGN(const Child gateway, Child::Start({"gateway", server.line()}));
  return MeasureChurn(server, gateway, PortOf(gateway),
                      {.phones = flags.churn_phones, .seconds = flags.seconds});
}

/// Layouts that are no rows of the table.
const std::vector<std::pair<std::string, Result<void> (*)(const Flags&)>> kOwnTables{
    {"apps", MeasureAppTimes},
    {"peers", MeasureAllPeers},
    {"churn", MeasureChurnOfGateway},
    {"discovery", [](const Flags& flags) { return MeasureDiscovery(flags.phones); }}};

std::string Load() {
  std::ifstream file("/proc/loadavg");
  std::string one, five, fifteen;
  file >> one >> five >> fifteen;
  return one;
}

int Run(const Flags& flags) {
  fmt::print("phones report at {} Hz for {} s; {} processors, load {} at the beginning\n", flags.hz,
             flags.seconds, std::thread::hardware_concurrency(), Load());
  const auto fail = [](const Error& error) {
    fmt::print("{}\n", ToString(error));
    return 1;
  };
  std::vector<Row> rows;
  const auto is_row = [](const std::string& layout) {
    return std::ranges::count(kOwnTables, layout, [](const auto& own) { return own.first; }) == 0;
  };
  if (std::ranges::any_of(flags.layouts, is_row)) PrintHead();
  for (const std::string& layout : flags.layouts) {
    if (!is_row(layout)) continue;
    for (const int phones : layout == "bus" ? std::vector<int>{flags.bus_phones} : flags.phones) {
      const auto row =
          layout == "bus" ? MeasureBus(phones, flags) : MeasureGateway(layout, phones, flags);
      if (!row) return fail(row.error());
      Print(*row);
      rows.push_back(*row);
    }
  }
  PrintGrowth(rows);
  for (const auto& [layout, measure] : kOwnTables) {
    if (std::ranges::find(flags.layouts, layout) == flags.layouts.end()) continue;
    if (const auto measured = measure(flags); !measured.ok()) return fail(measured.error());
  }
  const bool is_written = (flags.csv.empty() || WriteCsv(rows, flags.csv)) &&
                          (flags.plot.empty() || WritePlot(rows, flags.plot));
  if (!is_written) fmt::print("cannot write {} or {}\n", flags.csv, flags.plot);
  return is_written ? 0 : 1;
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) {
  using namespace waymark::bench;
  CLI::App app(
      "Phones that walk, report their poses and listen: latency, bytes, processor time and "
      "memory.\n"
      "Layouts: city and square: one room, its phones spread over a city or packed in a square;\n"
      "rooms: many rooms, each a square; bus: phones on DDS, without a gateway, in 20 cells;\n"
      "apps: what the device library sees that joins a room of 100 phones;\n"
      "peers: rooms through the gateway, mosquitto, Redis and a plain WebSocket fan-out;\n"
      "churn: crowds come and die for the given seconds; what server and gateway hold;\n"
      "discovery: octets until devices on the bus have joined; in a namespace: unshare -n.\n"
      "Example: session_bench --layouts city,square --phones 10,100,1000 --plot crowd.svg",
      "session_bench");
  Flags flags;
  app.add_option("--layouts", flags.layouts, "what is measured, in this order")
      ->delimiter(',')
      ->check(
          CLI::IsMember({"city", "square", "rooms", "bus", "apps", "peers", "churn", "discovery"}))
      ->capture_default_str();
  app.add_option("--phones", flags.phones, "how many, each a measurement")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--per-room", flags.per_room, "phones of a room, of layout rooms")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--bus-phones", flags.bus_phones, "phones of layout bus")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--city", flags.city_m, "edge of the city, m")->capture_default_str();
  app.add_option("--square", flags.square_m, "edge of a square, m")->capture_default_str();
  app.add_option("--seconds", flags.seconds, "of each measurement")->capture_default_str();
  app.add_option("--hz", flags.hz, "pose reports of a phone")->capture_default_str();
  app.add_option("--joins", flags.joins, "late joins of layout apps")->capture_default_str();
  app.add_option("--anchors", flags.anchors, "anchors placed in layout apps")
      ->capture_default_str();
  app.add_option("--churn-phones", flags.churn_phones, "phones at once of layout churn")
      ->capture_default_str();
  app.add_option("--csv", flags.csv, "file for all figures");
  app.add_option("--plot", flags.plot, "file for a plot of latency and bytes, SVG");
  int domain = 0, outcome = -1;
  app.add_subcommand("server", "")->group("")->callback([&] { outcome = RunServer(); });
  CLI::App* const gateway = app.add_subcommand("gateway", "")->group("");
  gateway->add_option("DOMAIN", domain)->required();
  app.add_subcommand("fan-out", "")->group("")->callback([&] { outcome = RunFanOut(); });
  gateway->callback([&] { outcome = RunGateway(domain); });
  CLI11_PARSE(app, argc, argv);
  return outcome >= 0 ? outcome : Run(flags);
}

// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/layouts.h"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "mapping/base/quantile.h"
#include "session/server/server.h"
#include "tests/bench/session/apps.h"
#include "tests/bench/session/bus_crowd.h"
#include "tests/bench/session/child.h"
#include "tests/bench/session/churn.h"
#include "tests/bench/session/crowd.h"
#include "tests/bench/session/peers/peers.h"

namespace waymark::bench {
namespace {

std::uint16_t PortOf(const Child& gateway) {
  return static_cast<std::uint16_t>(std::stoi(gateway.line()));
}

Result<Child> StartGateway(const Child& server, const Flags& flags) {
  std::vector<std::string> words{"gateway", server.line()};
  if (flags.is_tls) words.push_back("--tls");
  return Child::Start(words);
}

/// One that records, where that is wanted.
Result<Child> StartServer(const std::string& layout, int phones, const Flags& flags) {
  std::vector<std::string> words{"server"};
  if (!flags.recordings.empty()) {
    words.push_back(fmt::format("--record={}/{}-{}.wrec", flags.recordings, layout, phones));
  }
  return Child::Start(words);
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

constexpr int kOthers = 100, kFewOthers = 20;  // phones beside apps

/// Apps that join a room with the anchors of a city in which others walk.
Result<AppTimes> MeasureAppsBeside(int others, bool is_direct, const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const Child server,
                     Child::Start({"server", fmt::format("--anchors={}", flags.city_anchors),
                                   fmt::format("--city={}", flags.city_m)}));
  WAYMARK_TRY_ASSIGN(const Child gateway, Child::Start({"gateway", server.line()}));
  WAYMARK_TRY_ASSIGN(const auto crowd,
                     Crowd::Connect(PortOf(gateway), {.phones = others, .edge_m = flags.square_m}));
  WAYMARK_TRY(crowd->JoinAll());
  std::atomic<bool> is_over = false;
  std::thread walking([&] {
    while (!is_over) (void)crowd->Walk(0.1);
  });
  auto times = MeasureApps(
      {.server = is_direct ? "127.0.0.1" : fmt::format("ws://127.0.0.1:{}", gateway.line()),
       .domain = std::stoi(server.line()),
       .room = "room0",
       .others = others,
       .joins = flags.joins,
       .anchors = flags.anchors,
       .anchor_radius_m = flags.anchor_radius_m});
  is_over = true;
  walking.join();
  return times;
}

}  // namespace

Result<Row> MeasureGateway(const std::string& layout, int phones, const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const Child server, StartServer(layout, phones, flags));
  WAYMARK_TRY_ASSIGN(const Child gateway, StartGateway(server, flags));
  Crowd::Options options{.phones = phones, .hz = flags.hz, .is_tls = flags.is_tls};
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
  WAYMARK_TRY_ASSIGN(const auto crowd,
                     BusCrowd::Connect({.domain = std::stoi(server.line()), .phones = phones}));
  Row row{.layout = "bus", .phones = phones};
  WAYMARK_TRY_ASSIGN(row.join_s, crowd->JoinAll());
  Observe(
      server, nullptr, [&] { return crowd->Walk(flags.hz, flags.seconds); }, row);
  return row;
}

Result<void> MeasureAppTimes(const Flags& flags) {
  for (const bool is_direct : {false, true}) {
    WAYMARK_TRY_ASSIGN(const AppTimes times, MeasureAppsBeside(kOthers, is_direct, flags));
    fmt::print(
        "apps {}, beside {} phones: late join p50 {:.0f}, p99 {:.0f} ms ({} times), with {} of {} "
        "anchors; acknowledged anchor to another phone p50 {:.1f}, p99 {:.1f} ms ({} times)\n",
        is_direct ? "on the bus" : "through a gateway", kOthers, Quantile(times.joins_ms, 0.5, NAN),
        Quantile(times.joins_ms, 0.99, NAN), flags.joins, times.anchors_held, flags.city_anchors,
        Quantile(times.anchors_ms, 0.5, NAN), Quantile(times.anchors_ms, 0.99, NAN), flags.anchors);
  }
  return {};
}

Result<void> MeasureAllPeers(const Flags& flags) {
  constexpr const char* kWay = "gateway and server";
  std::vector<PeerRow> ours;
  for (const std::string layout : {"peers", "city"}) {
    const bool is_city = layout == "city";
    for (const int phones : flags.phones) {
      WAYMARK_TRY_ASSIGN(const Row row, MeasureGateway(layout, phones, flags));
      const double due = flags.hz * (flags.per_room - 1);
      ours.push_back({.scene = is_city ? "city" : "rooms",
                      .way = kWay,
                      .phones = phones,
                      .poses_per_s = row.poses_per_s * phones,
                      .share = is_city ? row.delivered : row.poses_per_s / due,
                      .age_p50_ms = row.age_p50_ms,
                      .age_p99_ms = row.age_p99_ms,
                      .bytes_per_s = row.bytes_per_s,
                      .broker_cores = row.server_cores + row.gateway_cores,
                      .phones_cores = row.generator_cores});
    }
  }
  std::vector<PeerAnchorRow> our_anchors;
  for (const int others : {kFewOthers, kOthers}) {
    WAYMARK_TRY_ASSIGN(AppTimes times, MeasureAppsBeside(others, false, flags));
    our_anchors.push_back({.way = kWay,
                           .others = others,
                           .times = {.joins_ms = std::move(times.joins_ms),
                                     .acknowledged_ms = std::move(times.anchors_ms),
                                     .sent_ms = std::move(times.asked_ms),
                                     .anchors_held = times.anchors_held}});
  }
  return MeasurePeers({.phones = flags.phones,
                       .per_room = flags.per_room,
                       .hz = flags.hz,
                       .seconds = flags.seconds,
                       .city_m = flags.city_m,
                       .others = {kFewOthers, kOthers},
                       .anchors = {.square_m = flags.square_m,
                                   .hz = flags.hz,
                                   .city_anchors = flags.city_anchors,
                                   .city_m = flags.city_m,
                                   .radius_m = flags.anchor_radius_m,
                                   .joins = flags.joins,
                                   .anchors = flags.anchors}},
                      ours, our_anchors);
}

Result<void> MeasureChurnOfGateway(const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const Child server, Child::Start({"server"}));
  WAYMARK_TRY_ASSIGN(const Child gateway, Child::Start({"gateway", server.line()}));
  return MeasureChurn(server, gateway, PortOf(gateway),
                      {.phones = flags.churn_phones, .seconds = flags.seconds});
}

}  // namespace waymark::bench

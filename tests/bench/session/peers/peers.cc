// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/peers/peers.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "mapping/base/quantile.h"
#include "mapping/base/time.h"
#include "tests/bench/session/peers/brokers.h"
#include "tests/bench/session/peers/peer_crowd.h"

namespace waymark::bench {
namespace {

using Clock = std::chrono::steady_clock;

Result<PeerRow> Measure(const std::string& scene, const Peer& peer, int phones,
                        const PeerOptions& options) {
  WAYMARK_TRY_ASSIGN(const Broker broker, peer.start());
  WAYMARK_TRY_ASSIGN(const auto crowd,
                     PeerCrowd::Connect(broker.port, *broker.protocol,
                                        {.phones = phones,
                                         .per_room = options.per_room,
                                         .hz = options.hz,
                                         .city_m = scene == "city" ? options.city_m : 0}));
  const double broker_s = broker.process.CpuS(), own_s = OwnCpuS();
  const auto begin = Clock::now();
  const PeerCrowd::Heard heard = crowd->Walk(options.seconds);
  const double wall_s = Seconds(Clock::now() - begin);
  if (crowd->Lost() > 0) fmt::print("{}: {} connections ended\n", peer.way, crowd->Lost());
  PeerRow row{.scene = scene, .way = peer.way, .phones = phones};
  row.poses_per_s = static_cast<double>(heard.poses) / heard.seconds;
  row.share = static_cast<double>(heard.poses) / static_cast<double>(heard.due);
  row.age_p50_ms = Quantile(heard.ages_ms, 0.5, NAN);
  row.age_p99_ms = Quantile(heard.ages_ms, 0.99, NAN);
  row.bytes_per_s = static_cast<double>(heard.bytes) / heard.seconds / phones;
  row.broker_cores = (broker.process.CpuS() - broker_s) / wall_s;
  row.phones_cores = (OwnCpuS() - own_s) / wall_s;
  return row;
}

void PrintHead() {
  fmt::print("{:<7} {:<20} {:>6} {:>9} {:>8} {:>7} {:>7} {:>7} {:>7} {:>7} {:>10}\n", "scene",
             "way", "phones", "poses/s", "of due %", "p50 ms", "p99 ms", "kB/s", "broker", "phones",
             "us a pose");
}

void Print(const PeerRow& row) {
  fmt::print(
      "{:<7} {:<20} {:>6} {:>9.0f} {:>8.1f} {:>7.1f} {:>7.1f} {:>7.1f} {:>7.3f} {:>7.3f} "
      "{:>10.2f}\n",
      row.scene, row.way, row.phones, row.poses_per_s, 100 * row.share, row.age_p50_ms,
      row.age_p99_ms, row.bytes_per_s / 1e3, row.broker_cores, row.phones_cores,
      1e6 * row.broker_cores / row.poses_per_s);
  std::fflush(stdout);
}

void Print(const PeerAnchorRow& row) {
  const AnchorTimes& times = row.times;
  const auto quantiles = [](const std::vector<float>& values) {
    if (values.empty()) return std::string("none is told");
    return fmt::format("{:.1f}, {:.1f}", Quantile(values, 0.5, NAN), Quantile(values, 0.99, NAN));
  };
  fmt::print("{:<20} {:>6} {:>8} {:>16} {:>16} {:>16}\n", row.way, row.others, times.anchors_held,
             quantiles(times.joins_ms), quantiles(times.acknowledged_ms), quantiles(times.sent_ms));
  std::fflush(stdout);
}

}  // namespace

Result<void> MeasurePeers(const PeerOptions& options, const std::vector<PeerRow>& ours,
                          const std::vector<PeerAnchorRow>& our_anchors) {
  const std::vector<Peer> peers = FindPeers();
  fmt::print(
      "phones at {} Hz; rooms: of {}, each heard by all others of its room; city: {:.0f} m wide, "
      "each "
      "heard by those in the nine cells of {:.0f} m around it, with us as their budgets have it\n",
      options.hz, options.per_room, options.city_m, Cell::kEdge_m);
  PrintHead();
  for (const PeerRow& row : ours) Print(row);
  for (const std::string scene : {"rooms", "city"}) {
    for (const Peer& peer : peers) {
      for (const int phones : options.phones) {
        WAYMARK_TRY_ASSIGN(const PeerRow row, Measure(scene, peer, phones, options));
        Print(row);
      }
    }
  }
  fmt::print(
      "{} anchors over the city, and phones that walk in a square of {:.0f} m: until a newcomer "
      "has "
      "the anchors around it and has heard everybody, and until another phone has one that was "
      "made; p50, p99 in ms\n",
      options.anchors.city_anchors, options.anchors.square_m);
  fmt::print("{:<20} {:>6} {:>8} {:>16} {:>16} {:>16}\n", "way", "phones", "anchors", "late join",
             "after its answer", "after sending");
  for (const PeerAnchorRow& row : our_anchors) Print(row);
  for (const Peer& peer : peers) {
    for (const int others : options.others) {
      PeerAnchorOptions anchors = options.anchors;
      anchors.others = others;
      WAYMARK_TRY_ASSIGN(const Broker broker, peer.start());
      WAYMARK_TRY_ASSIGN(auto times, MeasurePeerAnchors(broker.port, *broker.protocol, anchors));
      Print(PeerAnchorRow{peer.way, others, std::move(times)});
    }
  }
  return {};
}

}  // namespace waymark::bench

// SPDX-License-Identifier: Apache-2.0
// What a crowd costs: server, gateway and phones in three processes on this machine.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <string>
#include <thread>

#include "tests/bench/session/discovery.h"
#include "tests/bench/session/layouts.h"
#include "tests/bench/session/processes.h"
#include "tests/bench/session/summary.h"
#include "tests/bench/session/swap.h"

namespace waymark::bench {
namespace {

/// Layouts that are no rows of the table.
const std::vector<std::pair<std::string, Result<void> (*)(const Flags&)>> kOwnTables{
    {"apps", MeasureAppTimes},
    {"peers", MeasureAllPeers},
    {"churn", MeasureChurnOfGateway},
    {"swap",
     [](const Flags& flags) {
       return MeasureSwaps({.anchors = flags.swap_anchors,
                            .city_m = flags.city_m,
                            .anchor_radius_m = flags.anchor_radius_m});
     }},
    {"discovery", [](const Flags& flags) { return MeasureDiscovery(flags.phones, flags.slices); }}};

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
      "peers: rooms, a city, late joins and new anchors through the gateway, mosquitto, Redis and "
      "a\n"
      "plain WebSocket fan-out;\n"
      "churn: crowds come and die for the given seconds; what server and gateway hold;\n"
      "swap: releases go live under 100 phones in a room of so many anchors;\n"
      "discovery: octets until devices on the bus have joined; in a namespace: unshare -n.\n"
      "Example: session_bench --layouts city,square --phones 10,100,1000 --plot crowd.svg",
      "session_bench");
  Flags flags;
  app.add_option("--layouts", flags.layouts, "what is measured, in this order")
      ->delimiter(',')
      ->check(CLI::IsMember(
          {"city", "square", "rooms", "bus", "apps", "peers", "churn", "swap", "discovery"}))
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
  app.add_option("--city-anchors", flags.city_anchors,
                 "anchors that the room of layout apps holds, over the city")
      ->capture_default_str();
  app.add_option("--anchor-radius", flags.anchor_radius_m,
                 "metres around it in which an app of layout apps wants to know of anchors")
      ->capture_default_str();
  app.add_option("--swap-anchors", flags.swap_anchors,
                 "anchors that the room of layout swap holds, each a measurement")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--anchors", flags.anchors, "anchors placed in layout apps")
      ->capture_default_str();
  app.add_option("--slices", flags.slices, "into how many the bus is cut, of layout discovery")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--churn-phones", flags.churn_phones, "phones at once of layout churn")
      ->capture_default_str();
  app.add_flag("--tls", flags.is_tls, "phones and gateway encrypt what they say");
  app.add_option("--record", flags.recordings,
                 "folder in which the servers of city, square, rooms and peers record")
      ->check(CLI::ExistingDirectory);
  app.add_option("--csv", flags.csv, "file for all figures");
  app.add_option("--plot", flags.plot, "file for a plot of latency and bytes, SVG");
  int domain = 0, count = 0, first = 0, outcome = -1;
  std::string recording;
  CLI::App* const server = app.add_subcommand("server", "")->group("");
  server->add_option("--record", recording);
  server->add_option("--anchors", count);
  server->add_option("--city", flags.city_m);
  server->add_option("--slices", flags.slices);
  server->callback([&] { outcome = RunServer(recording, {count, flags.city_m}, flags.slices); });
  CLI::App* const gateway = app.add_subcommand("gateway", "")->group("");
  gateway->add_option("DOMAIN", domain)->required();
  gateway->add_flag("--tls", flags.is_tls);
  app.add_subcommand("fan-out", "")->group("")->callback([&] { outcome = RunFanOut(); });
  gateway->callback([&] { outcome = RunGateway(domain, flags.is_tls); });
  CLI::App* const devices = app.add_subcommand("devices", "")->group("");
  devices->add_option("DOMAIN", domain)->required();
  devices->add_option("COUNT", count)->required();
  devices->add_option("FIRST", first)->required();
  devices->add_option("--slices", flags.slices);
  devices->callback([&] { outcome = RunDevices(domain, count, first, flags.slices); });
  CLI11_PARSE(app, argc, argv);
  return outcome >= 0 ? outcome : Run(flags);
}

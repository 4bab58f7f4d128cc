// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/peers/peers.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "mapping/base/quantile.h"
#include "tests/bench/session/child.h"
#include "tests/bench/session/peers/peer_crowd.h"
#include "tests/bench/session/summary.h"

namespace waymark::bench {
namespace {

using Clock = std::chrono::steady_clock;

bool IsInstalled(const std::string& program) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (::access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  }
  return false;
}

sockaddr_in Loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

std::uint16_t FindFreePort() {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = Loopback(0);
  socklen_t length = sizeof address;
  (void)::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  (void)::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &length);
  ::close(descriptor);
  return ntohs(address.sin_port);
}

bool IsListening(std::uint16_t port) {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = Loopback(port);
  const bool is_open =
      ::connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(descriptor);
  return is_open;
}

/// A broker that runs, and how phones speak with it.
struct Broker {
  Child process;
  std::uint16_t port;
  std::unique_ptr<Protocol> protocol;
};

Result<Broker> Await(Result<Child> process, std::uint16_t port,
                     std::unique_ptr<Protocol> protocol) {
  if (!process) return process.error();
  const auto deadline = Clock::now() + std::chrono::seconds(10);
  while (!IsListening(port)) {
    if (Clock::now() > deadline) {
      return MakeError(ErrorCode::kUnavailable, "port {}: no broker came to listen", port);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return Broker{*std::move(process), port, std::move(protocol)};
}

Result<Broker> StartMosquitto() {
  const std::uint16_t port = FindFreePort();
  const auto file =
      std::filesystem::temp_directory_path() / fmt::format("mosquitto.{}.conf", ::getpid());
  std::ofstream(file) << fmt::format(
      "listener {} 127.0.0.1\nallow_anonymous true\nset_tcp_nodelay true\npersistence false\n"
      "user root\n",
      port);
  auto broker = Await(Child::StartOther({"mosquitto", "-c", file.string()}), port, MakeMqtt());
  std::filesystem::remove(file);
  return broker;
}

Result<Broker> StartRedis() {
  const std::uint16_t port = FindFreePort();
  return Await(Child::StartOther({"redis-server", "--port", std::to_string(port), "--bind",
                                  "127.0.0.1", "--save", "", "--appendonly", "no"}),
               port, MakeRedis());
}

Result<Broker> StartFanOut() {
  WAYMARK_TRY_ASSIGN(Child child, Child::Start({"fan-out"}));
  const auto port = static_cast<std::uint16_t>(std::stoi(child.line()));
  return Await(std::move(child), port, MakeWebSocketFanOut());
}

Result<PeerRow> Measure(const std::string& way, const Broker& broker, int phones,
                        const PeerOptions& options) {
  WAYMARK_TRY_ASSIGN(
      const auto crowd,
      PeerCrowd::Connect(broker.port, *broker.protocol,
                         {.phones = phones, .per_room = options.per_room, .hz = options.hz}));
  const double broker_s = broker.process.CpuS(), own_s = OwnCpuS();
  const auto begin = Clock::now();
  const PeerCrowd::Heard heard = crowd->Walk(options.seconds);
  const double wall_s = Seconds(Clock::now() - begin);
  if (crowd->Lost() > 0) fmt::print("{}: {} connections ended\n", way, crowd->Lost());
  PeerRow row{.way = way, .phones = phones};
  row.poses_per_s = static_cast<double>(heard.poses) / heard.seconds;
  row.share = row.poses_per_s / (phones * options.hz * (options.per_room - 1));
  row.age_p50_ms = Quantile(heard.ages_ms, 0.5, NAN);
  row.age_p99_ms = Quantile(heard.ages_ms, 0.99, NAN);
  row.broker_cores = (broker.process.CpuS() - broker_s) / wall_s;
  row.phones_cores = (OwnCpuS() - own_s) / wall_s;
  return row;
}

void Print(const PeerRow& row) {
  fmt::print("{:<20} {:>6} {:>10.0f} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.3f} {:>8.3f} {:>10.2f}\n",
             row.way, row.phones, row.poses_per_s, 100 * row.share, row.age_p50_ms, row.age_p99_ms,
             row.broker_cores, row.phones_cores, 1e6 * row.broker_cores / row.poses_per_s);
  std::fflush(stdout);
}

}  // namespace

Result<void> MeasurePeers(const PeerOptions& options, const std::vector<PeerRow>& ours) {
  fmt::print("phones in rooms of {} at {} Hz, each heard by all others of its room\n",
             options.per_room, options.hz);
  fmt::print("{:<20} {:>6} {:>10} {:>8} {:>8} {:>8} {:>8} {:>8} {:>10}\n", "way", "phones",
             "poses/s", "of due %", "p50 ms", "p99 ms", "broker", "phones", "us a pose");
  for (const PeerRow& row : ours) Print(row);
  const std::vector<std::tuple<std::string, std::string, Result<Broker> (*)()>> peers{
      {"WebSocket fan-out", "", StartFanOut},
      {"mosquitto, QoS 0", "mosquitto", StartMosquitto},
      {"Redis pub/sub", "redis-server", StartRedis}};
  for (const auto& [way, program, start] : peers) {
    if (!program.empty() && !IsInstalled(program)) {
      fmt::print("{}: not measured, {} is not installed\n", way, program);
      continue;
    }
    for (const int phones : options.phones) {
      WAYMARK_TRY_ASSIGN(const Broker broker, start());
      WAYMARK_TRY_ASSIGN(const PeerRow row, Measure(way, broker, phones, options));
      Print(row);
    }
  }
  return {};
}

}  // namespace waymark::bench

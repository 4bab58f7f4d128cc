// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/peers/brokers.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/support/loopback.h"

namespace waymark::bench {
namespace {

using support::Loopback;
using Clock = std::chrono::steady_clock;

bool IsInstalled(const std::string& program) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (::access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  }
  return false;
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

}  // namespace

std::vector<Peer> FindPeers() {
  std::vector<Peer> peers{{"WebSocket fan-out", StartFanOut}};
  const std::vector<std::pair<std::string, Peer>> programs{
      {"mosquitto", {"mosquitto", StartMosquitto}}, {"redis-server", {"Redis", StartRedis}}};
  for (const auto& [program, peer] : programs) {
    if (IsInstalled(program)) {
      peers.push_back(peer);
    } else {
      fmt::print("{}: not measured, {} is not installed\n", peer.way, program);
    }
  }
  return peers;
}

}  // namespace waymark::bench

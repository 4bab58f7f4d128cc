// SPDX-License-Identifier: Apache-2.0
// Records how long small messages take each way on a phone's network while images are uploaded on
// the same TCP connection: the traces that clock_estimator_test.cc replays.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <thread>
#include <vector>

#include "tests/network/emulator.h"

namespace waymark::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint16_t kPort = 4711;
constexpr std::size_t kPieceBytes = 512;  // an image is pieces between pings
constexpr std::uint8_t kPing = 1, kImage = 2;

using Piece = std::array<std::uint8_t, kPieceBytes>;

std::int64_t NowNs() { return Clock::now().time_since_epoch().count(); }

sockaddr_in Endpoint(const std::string& address) {
  sockaddr_in endpoint{};
  endpoint.sin_family = AF_INET;
  endpoint.sin_port = htons(kPort);
  ::inet_pton(AF_INET, address.c_str(), &endpoint.sin_addr);
  return endpoint;
}

bool ReadFully(int socket, std::uint8_t* to, std::size_t bytes) {
  return ::recv(socket, to, bytes, MSG_WAITALL) == static_cast<ssize_t>(bytes);
}

/// Answers each ping with when it came.
void Serve(int listener) {
  const int client = ::accept(listener, nullptr, nullptr);
  const int yes = 1;
  ::setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  for (Piece piece; ReadFully(client, piece.data(), piece.size());) {
    if (piece[0] != kPing) continue;
    std::array<std::int64_t, 2> answer{0, NowNs()};
    std::copy_n(piece.data() + 8, 8, reinterpret_cast<std::uint8_t*>(answer.data()));
    if (::send(client, answer.data(), sizeof answer, MSG_NOSIGNAL) < 0) break;
  }
  ::close(client);
}

/// Four pings a second, an image every second; prints both delays of each ping.
void Talk(const std::string& server, double seconds, std::size_t image_bytes) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  const sockaddr_in endpoint = Endpoint(server);
  const int yes = 1, little = 4096;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  ::setsockopt(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &little, sizeof little);
  CHECK(::connect(socket, reinterpret_cast<const sockaddr*>(&endpoint), sizeof endpoint) == 0);
  std::thread listening([&] {
    std::array<std::int64_t, 2> answer{};
    while (ReadFully(socket, reinterpret_cast<std::uint8_t*>(answer.data()), sizeof answer)) {
      const std::int64_t now = NowNs();
      fmt::print("{} {}\n", (answer[1] - answer[0]) / 1000, (now - answer[1]) / 1000);
    }
  });
  const Clock::time_point begin = Clock::now();
  Clock::time_point next_image = begin + std::chrono::milliseconds(230);  // just before a ping
  std::size_t image_left = 0;
  for (int ping = 0; ping < 4 * seconds;) {
    Piece piece{};
    const auto due = begin + ping * std::chrono::milliseconds(250);
    if (Clock::now() >= due) {
      ++ping;
      const std::int64_t now = NowNs();
      piece[0] = kPing;
      std::copy_n(reinterpret_cast<const std::uint8_t*>(&now), 8, piece.data() + 8);
    } else if (image_left > 0) {
      piece[0] = kImage;
      image_left -= std::min(image_left, kPieceBytes);
    } else if (Clock::now() >= next_image) {
      next_image += std::chrono::seconds(1);
      image_left = image_bytes;
      continue;
    } else {
      std::this_thread::sleep_until(std::min(due, next_image));
      continue;
    }
    if (::send(socket, piece.data(), piece.size(), MSG_NOSIGNAL) < 0) break;
  }
  std::this_thread::sleep_for(std::chrono::seconds(2));
  ::shutdown(socket, SHUT_RDWR);
  listening.join();
  ::close(socket);
}

Result<void> Run(const std::string& profile, double seconds, std::size_t image_bytes) {
  const network::Profile* const found = network::FindProfile(profile);
  if (found == nullptr) return MakeError(ErrorCode::kNotFound, "no profile \"{}\"", profile);
  WAYMARK_TRY_ASSIGN(const auto emulator, network::Emulator::Create(1));
  WAYMARK_TRY_ASSIGN(const int server, emulator->AddHost(*network::FindProfile("none")));
  WAYMARK_TRY_ASSIGN(const int phone, emulator->AddHost(*found));
  int listener = -1;
  emulator->Inside(server).Run([&] {
    listener = ::socket(AF_INET, SOCK_STREAM, 0);
    const sockaddr_in any = Endpoint("0.0.0.0");
    CHECK(::bind(listener, reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0);
    CHECK(::listen(listener, 1) == 0);
  });
  std::thread serving([&] { Serve(listener); });
  emulator->Inside(phone).Run([&] { Talk(emulator->Address(server), seconds, image_bytes); });
  serving.join();
  ::close(listener);
  return {};
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) {
  CLI::App app("Prints the delay of small messages each way, in microseconds, while images go up.",
               "record_delays");
  std::string profile = "4g";
  double seconds = 120;
  std::size_t image_bytes = 20'000;
  app.add_option("profile", profile, "4g, 3g, crowded")->capture_default_str();
  app.add_option("--seconds", seconds)->capture_default_str();
  app.add_option("--image-bytes", image_bytes, "each second")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto outcome = waymark::bench::Run(profile, seconds, image_bytes);
  if (!outcome) fmt::print(stderr, "record_delays: {}\n", ToString(outcome.error()));
  return outcome.ok() ? 0 : 1;
}

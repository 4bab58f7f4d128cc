// SPDX-License-Identifier: Apache-2.0
#include "tests/network/slow_relay.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <numeric>

#include "tests/support/loopback.h"

namespace waymark::network {
namespace {

using support::Loopback;

/// A connection to ourselves through the relay.
struct Loop {
  explicit Loop(const Profile& profile) {
    const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = Loopback(0);
    socklen_t length = sizeof address;
    EXPECT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&address), length), 0);
    EXPECT_EQ(::listen(listener, 1), 0);
    EXPECT_EQ(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &length), 0);
    relay = *SlowRelay::Start(ntohs(address.sin_port), profile, 1);
    client = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    address = Loopback(relay->port());
    EXPECT_EQ(::connect(client, reinterpret_cast<sockaddr*>(&address), length), 0);
    server = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    ::close(listener);
  }
  ~Loop() {
    ::close(client);
    ::close(server);
  }

  std::unique_ptr<SlowRelay> relay;
  int client = -1, server = -1;
};

std::vector<std::uint8_t> ReadFully(int socket, std::size_t bytes) {
  std::vector<std::uint8_t> all(bytes);
  std::size_t got = 0;
  while (got < bytes) {
    const auto more = ::recv(socket, all.data() + got, bytes - got, 0);
    if (more <= 0) break;
    got += static_cast<std::size_t>(more);
  }
  all.resize(got);
  return all;
}

TEST(SlowRelay, BytesArriveWholeInOrderAndAsLateAsTheyShould) {
  const Loop loop({.name = "slow",
                   .source = "",
                   .up = {.delay = milliseconds(20),
                          .jitter = milliseconds(10),
                          .rate_bps = 8e6,
                          .queue = milliseconds(100),
                          .loss = 0.05},
                   .down = {.delay = milliseconds(20)}});
  std::vector<std::uint8_t> bytes(50'000);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  const Instant sent = std::chrono::steady_clock::now();
  std::thread sending(
      [&] { EXPECT_EQ(::send(loop.client, bytes.data(), bytes.size(), 0), 50'000); });
  EXPECT_EQ(ReadFully(loop.server, bytes.size()), bytes);
  sending.join();
  EXPECT_GE(std::chrono::steady_clock::now() - sent, milliseconds(60)) << "50 ms for the bytes";
  ASSERT_EQ(::send(loop.server, "x", 1, 0), 1);
  EXPECT_EQ(ReadFully(loop.client, 1).size(), 1u);
}

TEST(SlowRelay, EndsWhatOneEndEnds) {
  Loop loop(*FindProfile("none"));
  ::shutdown(loop.client, SHUT_RDWR);
  EXPECT_TRUE(ReadFully(loop.server, 1).empty());
}

TEST(SlowRelay, IsSilentWhileCut) {
  const Loop loop(*FindProfile("none"));
  loop.relay->Cut(true);
  ASSERT_EQ(::send(loop.client, "x", 1, 0), 1);
  std::uint8_t byte = 0;
  const timeval limit{0, 50'000};
  ::setsockopt(loop.server, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  EXPECT_LT(::recv(loop.server, &byte, 1, 0), 0);
  loop.relay->Cut(false);
  const timeval none{0, 0};
  ::setsockopt(loop.server, SOL_SOCKET, SO_RCVTIMEO, &none, sizeof none);
  EXPECT_EQ(ReadFully(loop.server, 1).size(), 1u);
}

}  // namespace
}  // namespace waymark::network

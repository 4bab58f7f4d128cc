// SPDX-License-Identifier: Apache-2.0
// Packets between namespaces.
#include "tests/network/emulator.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <thread>

#include "tests/network/emulator_fixture.h"

namespace waymark::network {
namespace {

constexpr std::uint16_t kPort = 4711;

sockaddr_in Endpoint(const std::string& address) {
  sockaddr_in endpoint{};
  endpoint.sin_family = AF_INET;
  endpoint.sin_port = htons(kPort);
  ::inet_pton(AF_INET, address.c_str(), &endpoint.sin_addr);
  return endpoint;
}

/// A UDP socket of a host.
class Port {
 public:
  Port(const Emulator& emulator, int host) {
    emulator.Inside(host).Run([&] { socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0); });
    const sockaddr_in any = Endpoint("0.0.0.0");
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&any), sizeof any), 0);
  }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  ~Port() { ::close(socket_); }

  bool Send(const std::string& address, int number) const {
    const sockaddr_in to = Endpoint(address);
    return ::sendto(socket_, &number, sizeof number, 0, reinterpret_cast<const sockaddr*>(&to),
                    sizeof to) == sizeof number;
  }
  /// The next number; nothing comes within the time.
  std::optional<int> Receive(milliseconds patience) const {
    const timeval limit{0, 1000 * static_cast<suseconds_t>(patience.count())};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    int number = 0;
    if (::recv(socket_, &number, sizeof number, 0) != sizeof number) return std::nullopt;
    return number;
  }

 private:
  int socket_ = -1;
};

TEST_F(EmulatorTest, PacketsArriveAsLateAsTheProfileSays) {
  const int phone = AddPhone("4g");
  const Port at_server(*emulator_, kServer), at_phone(*emulator_, phone);
  const Instant sent = std::chrono::steady_clock::now();
  int received = 0;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(at_phone.Send(emulator_->Address(kServer), i));
    if (at_server.Receive(milliseconds(900))) ++received;
  }
  EXPECT_GE(received, 15);
  EXPECT_GE(std::chrono::steady_clock::now() - sent, received * milliseconds(25));
  EXPECT_EQ(emulator_->CountersUp(phone).packets, 20u);
}

TEST_F(EmulatorTest, PhonesReachEachOtherAndCutOnesNobody) {
  const int one = AddPhone("none"), other = AddPhone("none");
  const Port at_one(*emulator_, one), at_other(*emulator_, other);
  ASSERT_TRUE(at_one.Send(emulator_->Address(other), 7));
  EXPECT_EQ(at_other.Receive(milliseconds(900)), 7);
  emulator_->Cut(other, true);
  ASSERT_TRUE(at_one.Send(emulator_->Address(other), 8));
  EXPECT_FALSE(at_other.Receive(milliseconds(50)));
  emulator_->Cut(other, false);
  ASSERT_TRUE(at_one.Send(emulator_->Address(other), 9));
  EXPECT_EQ(at_other.Receive(milliseconds(900)), 9);
}

TEST_F(EmulatorTest, AChangedAddressIsAnother) {
  const int phone = AddPhone("none");
  const std::string before = emulator_->Address(phone);
  const Port at_server(*emulator_, kServer), at_phone(*emulator_, phone);
  ASSERT_TRUE(emulator_->ChangeAddress(phone).ok());
  EXPECT_NE(emulator_->Address(phone), before);
  ASSERT_TRUE(at_server.Send(before, 1));
  EXPECT_FALSE(at_phone.Receive(milliseconds(50)));
  ASSERT_TRUE(at_server.Send(emulator_->Address(phone), 2));
  EXPECT_EQ(at_phone.Receive(milliseconds(900)), 2);
}

}  // namespace
}  // namespace waymark::network

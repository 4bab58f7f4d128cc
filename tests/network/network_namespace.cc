// SPDX-License-Identifier: Apache-2.0
#include "tests/network/network_namespace.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "mapping/base/process.h"

namespace waymark::network {
namespace {

Error Failed(const char* what) {
  return MakeError(ErrorCode::kUnavailable, "{}: {}", what, std::strerror(errno));
}

ifreq Named(const std::string& device) {
  ifreq request{};
  device.copy(request.ifr_name, IFNAMSIZ - 1);
  return request;
}

void SetIp(sockaddr& field, const std::string& text) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  ::inet_pton(AF_INET, text.c_str(), &address.sin_addr);
  std::memcpy(&field, &address, sizeof address);
}

Result<void> Configure(const std::string& device, const std::string& address,
                       const std::string& mask) {
  const int control = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (control < 0) return Failed("socket");
  ifreq with_address = Named(device), with_mask = Named(device), with_flags = Named(device);
  SetIp(with_address.ifr_addr, address);
  SetIp(with_mask.ifr_netmask, mask);
  with_flags.ifr_flags = IFF_UP | IFF_RUNNING;
  const bool is_set = ::ioctl(control, SIOCSIFADDR, &with_address) == 0 &&
                      ::ioctl(control, SIOCSIFNETMASK, &with_mask) == 0 &&
                      ::ioctl(control, SIOCSIFFLAGS, &with_flags) == 0;
  const Error failure = Failed("address of a device");
  ::close(control);
  if (!is_set) return failure;
  return {};
}

Result<int> OpenTunHere(const std::string& name) {
  const int descriptor = ::open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return Failed("/dev/net/tun");
  ifreq request = Named(name);
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  if (::ioctl(descriptor, TUNSETIFF, &request) == 0) return descriptor;
  const Error failure = Failed("TUN device");
  ::close(descriptor);
  return failure;
}

}  // namespace

Result<NetworkNamespace> NetworkNamespace::Create() {
  Result<int> descriptor = 0;
  std::thread([&] {
    if (::unshare(CLONE_NEWNET) != 0) {
      descriptor = Failed("network namespace (needs root)");
    } else {
      descriptor = ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
    }
  }).join();
  if (!descriptor) return descriptor.error();
  NetworkNamespace made(*descriptor);
  WAYMARK_TRY(made.SetAddress("lo", "127.0.0.1", "255.0.0.0"));
  return made;
}

NetworkNamespace::NetworkNamespace(NetworkNamespace&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

NetworkNamespace& NetworkNamespace::operator=(NetworkNamespace&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

NetworkNamespace::~NetworkNamespace() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void NetworkNamespace::Run(const std::function<void()>& body) const {
  std::thread([&] {
    CHECK(::setns(descriptor_, CLONE_NEWNET) == 0);
    body();
  }).join();
}

Result<void> NetworkNamespace::Run(const std::vector<std::string>& words) const {
  Result<ProgramOutcome> outcome = ProgramOutcome{};
  Run([&] { outcome = CaptureProgram(words); });
  if (!outcome) return outcome.error();
  if (outcome->status == 0) return {};
  return MakeError(ErrorCode::kUnavailable, "{}: {}", words.front(), outcome->output);
}

Result<int> NetworkNamespace::OpenTun(const std::string& name) const {
  Result<int> descriptor = 0;
  Run([&] { descriptor = OpenTunHere(name); });
  return descriptor;
}

Result<void> NetworkNamespace::SetAddress(const std::string& device, const std::string& address,
                                          const std::string& mask) const {
  Result<void> outcome;
  Run([&] { outcome = Configure(device, address, mask); });
  return outcome;
}

std::string NetworkNamespace::Path() const {
  return fmt::format("/proc/{}/fd/{}", ::getpid(), descriptor_);
}

}  // namespace waymark::network

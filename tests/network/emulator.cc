// SPDX-License-Identifier: Apache-2.0
#include "tests/network/emulator.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>

namespace waymark::network {
namespace {

constexpr std::array<std::uint8_t, 3> kNet{10, 80, 0};
constexpr std::size_t kAddressOffset = 16;  // of the destination in an IPv4 header
constexpr std::size_t kHeaderBytes = 20;
constexpr const char* kMask = "255.255.255.0";
constexpr const char* kDevice = "emu0";

std::string AddressText(std::uint8_t last) {
  return fmt::format("{}.{}.{}.{}", kNet[0], kNet[1], kNet[2], last);
}

/// The last octet of the destination, or 0 when it is not ours to carry.
std::uint8_t Destination(std::span<const std::uint8_t> packet) {
  if (packet.size() < kHeaderBytes || packet[0] >> 4 != 4) return 0;
  const auto address = packet.subspan(kAddressOffset, 4);
  return std::equal(kNet.begin(), kNet.end(), address.begin()) ? address[3] : 0;
}

/// What phones have, whatever this machine has.
void UsePhonesCongestionControl() {
  std::ofstream("/proc/sys/net/ipv4/tcp_congestion_control") << "cubic";
}

}  // namespace

Result<std::unique_ptr<Emulator>> Emulator::Create(std::uint64_t seed) {
  const int wake = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake < 0) return MakeError(ErrorCode::kUnavailable, "no eventfd to be had");
  std::unique_ptr<Emulator> emulator(new Emulator(seed, wake));
  emulator->thread_ = std::thread([raw = emulator.get()] { raw->Work(); });
  return emulator;
}

Emulator::~Emulator() {
  is_stopping_ = true;
  ::eventfd_write(wake_, 1);
  thread_.join();
  for (const auto& host : hosts_) ::close(host->tun);
  ::close(wake_);
}

Result<int> Emulator::AddHost(const Profile& profile) {
  WAYMARK_TRY_ASSIGN(NetworkNamespace inside, NetworkNamespace::Create());
  inside.Run(UsePhonesCongestionControl);
  WAYMARK_TRY_ASSIGN(const int tun, inside.OpenTun(kDevice));
  const std::lock_guard lock(mutex_);
  const std::uint8_t address = next_address_++;
  if (const auto set = inside.SetAddress(kDevice, AddressText(address), kMask); !set) {
    ::close(tun);
    return set.error();
  }
  const int number = static_cast<int>(hosts_.size());
  const std::uint64_t seed = seed_ + 2 * hosts_.size();
  hosts_.push_back(std::make_unique<Host>(
      Host{std::move(inside), tun, address, Link(profile.up, seed), Link(profile.down, seed + 1)}));
  by_address_[address] = number;
  ::eventfd_write(wake_, 1);
  return number;
}

const Emulator::Host& Emulator::HostOf(int host) const {
  const std::lock_guard lock(mutex_);
  return *hosts_.at(static_cast<std::size_t>(host));
}

std::string Emulator::Address(int host) const {
  const Host& found = HostOf(host);
  const std::lock_guard lock(mutex_);
  return AddressText(found.address);
}

void Emulator::SetProfile(int host, const Profile& profile) {
  Host& found = HostOf(host);
  const std::lock_guard lock(mutex_);
  found.up.SetOptions(profile.up);
  found.down.SetOptions(profile.down);
}

void Emulator::Cut(int host, bool is_cut) {
  Host& found = HostOf(host);
  const std::lock_guard lock(mutex_);
  found.up.Cut(is_cut);
  found.down.Cut(is_cut);
}

Result<void> Emulator::ChangeAddress(int host) {
  Host& found = HostOf(host);
  const std::lock_guard lock(mutex_);
  by_address_.erase(found.address);
  found.address = next_address_++;
  by_address_[found.address] = host;
  return found.inside.SetAddress(kDevice, AddressText(found.address), kMask);
}

LinkCounters Emulator::CountersUp(int host) const {
  const Host& found = HostOf(host);
  const std::lock_guard lock(mutex_);
  return found.up.counters();
}

LinkCounters Emulator::CountersDown(int host) const {
  const Host& found = HostOf(host);
  const std::lock_guard lock(mutex_);
  return found.down.counters();
}

// ---- the router -------------------------------------------------------------------------------

void Emulator::Work() {
  // Delays shall be the profile's, not those of a busy machine. Without the right to it: as it is.
  (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), -15);
  while (!is_stopping_) {
    std::vector<pollfd> waiting{{wake_, POLLIN, 0}};
    timespec patience{1, 0};
    {
      const std::lock_guard lock(mutex_);
      for (const auto& host : hosts_) waiting.push_back({host->tun, POLLIN, 0});
      if (!under_way_.empty()) {
        const auto left = std::clamp<Instant::duration>(
            under_way_.top().due - std::chrono::steady_clock::now(), Instant::duration::zero(),
            std::chrono::milliseconds(900));
        patience = {0, static_cast<long>(left.count())};
      }
    }
    ::ppoll(waiting.data(), waiting.size(), &patience, nullptr);
    eventfd_t ignored = 0;
    if (waiting.front().revents != 0) ::eventfd_read(wake_, &ignored);
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 1; i < waiting.size(); ++i) {
      if (waiting[i].revents != 0)
        TakeFrom(static_cast<int>(i) - 1, std::chrono::steady_clock::now());
    }
    PassOn(std::chrono::steady_clock::now());
  }
}

void Emulator::TakeFrom(int host, Instant now) {
  std::array<std::uint8_t, 2048> buffer;
  Host& from = *hosts_[static_cast<std::size_t>(host)];
  for (int i = 0; i < 64; ++i) {  // then it is the others' turn
    const auto bytes = ::read(from.tun, buffer.data(), buffer.size());
    if (bytes <= 0) return;
    const std::span packet(buffer.data(), static_cast<std::size_t>(bytes));
    const auto to = by_address_.find(Destination(packet));
    if (to == by_address_.end()) continue;
    Carry({.due = now,
           .number = 0,
           .to = to->second,
           .has_arrived_at_router = false,
           .bytes = {packet.begin(), packet.end()}},
          from.up, now);
  }
}

void Emulator::Carry(Packet packet, Link& link, Instant now) {
  const auto out = link.Carry(packet.bytes.size(), now);
  if (!out) return;
  packet.due = *out;
  packet.number = next_number_++;
  under_way_.push(std::move(packet));
}

/// Up to the router first, then down to the other host.
void Emulator::PassOn(Instant now) {
  while (!under_way_.empty() && under_way_.top().due <= now) {
    Packet packet = under_way_.top();
    under_way_.pop();
    Host& to = *hosts_[static_cast<std::size_t>(packet.to)];
    if (packet.has_arrived_at_router) {
      // A full device drops it, as any would.
      [[maybe_unused]] const auto written =
          ::write(to.tun, packet.bytes.data(), packet.bytes.size());
      continue;
    }
    packet.has_arrived_at_router = true;
    const Instant arrived = packet.due;
    Carry(std::move(packet), to.down, arrived);
  }
}

}  // namespace waymark::network

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <queue>
#include <string>
#include <thread>
#include <vector>

#include "tests/network/network_namespace.h"
#include "tests/network/profiles.h"

namespace waymark::network {

/// Hosts in namespaces of their own, joined by one router that treats each host's packets as its
/// profile says. Hosts stand at 10.80.0.1, 10.80.0.2, … and reach each other; the first is by
/// custom the server's, without a profile. What runs in them need not know. Their TCP is CUBIC, as
/// on phones. Needs root and /dev/net/tun. Thread-safe.
class Emulator {
 public:
  /// Errors: Unavailable, with what is missing.
  static Result<std::unique_ptr<Emulator>> Create(std::uint64_t seed);
  ~Emulator();

  /// Adds a host; its number counts from 0. Errors: Unavailable.
  Result<int> AddHost(const Profile& profile);
  const NetworkNamespace& Inside(int host) const { return HostOf(host).inside; }
  std::string Address(int host) const;

  void SetProfile(int host, const Profile& profile);
  /// Nothing from or to it arrives until it is joined again.
  void Cut(int host, bool is_cut);
  /// It has another address from now on; packets to the old one are lost. Errors: Unavailable.
  Result<void> ChangeAddress(int host);

  LinkCounters CountersUp(int host) const;
  LinkCounters CountersDown(int host) const;

 private:
  struct Host {
    NetworkNamespace inside;
    int tun;
    std::uint8_t address;  // last octet
    Link up, down;
  };
  struct Packet {
    Instant due;
    std::uint64_t number;
    int to;
    bool has_arrived_at_router;
    std::vector<std::uint8_t> bytes;
  };
  struct Later {
    bool operator()(const Packet& a, const Packet& b) const {
      return a.due != b.due ? a.due > b.due : a.number > b.number;
    }
  };

  Emulator(std::uint64_t seed, int wake) : seed_(seed), wake_(wake) {}

  const Host& HostOf(int host) const;
  Host& HostOf(int host) { return const_cast<Host&>(std::as_const(*this).HostOf(host)); }
  void Work();
  void TakeFrom(int host, Instant now);
  void Carry(Packet packet, Link& link, Instant now);
  void PassOn(Instant now);

  const std::uint64_t seed_;
  const int wake_;
  std::atomic<bool> is_stopping_ = false;
  mutable std::mutex mutex_;
  // Guarded by mutex_; hosts are never removed.
  std::vector<std::unique_ptr<Host>> hosts_;
  std::map<std::uint8_t, int> by_address_;
  std::uint8_t next_address_ = 1;
  std::priority_queue<Packet, std::vector<Packet>, Later> under_way_;
  std::uint64_t next_number_ = 0;

  std::thread thread_;
};

}  // namespace waymark::network

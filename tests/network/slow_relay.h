// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "mapping/base/result.h"
#include "tests/network/profiles.h"

namespace waymark::network {

/// A TCP relay on loopback that passes bytes on as late as a profile says: a bad network for tests
/// without namespaces. TCP repairs losses, so here a lost piece is one that comes a retransmission
/// later, and all behind it wait. Thread-safe.
class SlowRelay {
 public:
  /// Relays to a port of this machine. Errors: Unavailable.
  static Result<std::unique_ptr<SlowRelay>> Start(std::uint16_t to_port, const Profile& profile,
                                                  std::uint64_t seed);
  ~SlowRelay();

  std::uint16_t port() const { return port_; }
  void SetProfile(const Profile& profile);
  /// Silence: connections stay, nothing moves until it is joined again.
  void Cut(bool is_cut);

 private:
  struct Piece {
    Instant due;
    std::vector<std::uint8_t> bytes;
    std::size_t passed = 0;
  };
  /// One direction of a connection.
  struct Way {
    int from, to;
    Link link;
    std::deque<Piece> under_way = {};
    std::size_t waiting_bytes = 0;
  };
  struct Connection {
    Way up, down;
  };

  SlowRelay(int listener, std::uint16_t port, std::uint16_t to_port, const Profile& profile,
            std::uint64_t seed)
      : listener_(listener), port_(port), to_port_(to_port), profile_(profile), seed_(seed) {}

  void Work();
  void Accept();
  bool Move(Way& way, bool is_readable, Instant now);
  Instant NextDue() const;

  const int listener_;
  const std::uint16_t port_, to_port_;
  std::atomic<bool> is_stopping_ = false;
  std::mutex mutex_;
  // Guarded by mutex_.
  Profile profile_;
  std::uint64_t seed_;
  bool is_cut_ = false;
  std::vector<std::unique_ptr<Connection>> connections_;

  std::thread thread_;
};

}  // namespace waymark::network

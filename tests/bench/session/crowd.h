// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "tests/bench/session/walker.h"
#include "tests/bench/session/web_socket.h"

namespace waymark::bench {

/// Many phones in one thread, which walk in groups of four, report their poses and listen, each on
/// a connection of its own to a gateway. Those of a group report a quarter of a period apart.
class Crowd {
 public:
  struct Options {
    int phones = 100;
    std::uint64_t per_room = 1'000'000;  ///< phones stand in rooms of so many
    double edge_m = 50;                  ///< of the square that each room's phones are spread over
    double hz = 30;                      ///< of reports
    bool is_tls = false;
    std::uint64_t first_phone = 0;  ///< which devices they are: those from this one on
    double area_radius_m = 0;       ///< in which they want to know of anchors; 0: of none
  };

  /// Errors: Unavailable.
  static Result<std::unique_ptr<Crowd>> Connect(std::uint16_t gateway_port, const Options& options);
  ~Crowd();

  /// Waits until all are welcome; says how long it took. Errors: Timeout (a minute).
  Result<double> JoinAll();
  /// All report poses for so long; what is heard after the first second is counted.
  Walked Walk(double seconds);
  /// Connections that ended meanwhile.
  int Lost() const { return lost_; }

 private:
  struct Phone;

  explicit Crowd(const Options& options);
  /// Handles what has arrived.
  void Listen();
  void OnMessage(Phone& phone, std::span<const std::uint8_t> message);
  /// What counts while phones walk.
  void Count(Phone& phone, std::span<const std::uint8_t> message);

  Options options_;
  std::vector<std::unique_ptr<Phone>> phones_;
  int poll_ = -1;
  int lost_ = 0;
  std::size_t welcome_ = 0;
  bool is_counting_ = false;
  double longest_wait_ms_ = 0;
  std::uint64_t epoch_before_ = 1;  // when counting began
  HeardOfSwap swap_;
};

}  // namespace waymark::bench

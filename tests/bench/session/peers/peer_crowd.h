// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "mapping/base/result.h"
#include "tests/bench/session/peers/cells.h"
#include "tests/bench/session/peers/protocol.h"

namespace waymark::bench {

/// Phones in one thread that publish every pose to a broker. Those in rooms hear all of their room;
/// those in a city publish to the topic of their cell and hear the nine around them, others as they
/// walk.
class PeerCrowd {
 public:
  struct Options {
    int phones = 100;
    int per_room = 20;
    double hz = 30;     ///< of reports
    double city_m = 0;  ///< edge; 0: in rooms
    int first_phone = 0;
  };
  /// Waits until each was answered. Errors: Unavailable.
  static Result<std::unique_ptr<PeerCrowd>> Connect(std::uint16_t port, const Protocol& protocol,
                                                    const Options& options);
  ~PeerCrowd();

  struct Heard {
    std::uint64_t poses = 0;     ///< of others
    std::uint64_t due = 0;       ///< to whoever was subscribed when they were reported
    std::uint64_t bytes = 0;     ///< of all phones
    std::uint64_t moves = 0;     ///< into another cell
    std::vector<float> ages_ms;  ///< from report to hearing, of every eighth
    double seconds = 0;
  };
  /// All report for so long; what is heard after the first second is counted.
  Heard Walk(double seconds);
  int Lost() const { return lost_; }

 private:
  struct Phone;

  PeerCrowd(const Protocol& protocol, const Options& options);
  void Enter(Phone& phone, const Cell& cell);
  void Report(std::size_t phone);
  void Listen();
  bool Receive(Phone& phone);
  void Count(const Phone& phone, std::span<const std::uint8_t> payload);

  const Protocol& protocol_;
  const Options options_;
  std::vector<std::unique_ptr<Phone>> phones_;
  std::map<Cell, int> in_cell_;  // phones
  int poll_ = -1;
  int lost_ = 0;
  bool is_counting_ = false;
  Heard heard_;
};

}  // namespace waymark::bench

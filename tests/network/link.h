// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>

namespace waymark::network {

using Instant = std::chrono::steady_clock::time_point;
using std::chrono::microseconds;
using std::chrono::milliseconds;

/// One direction of a way through a network. The default carries everything at once.
struct LinkOptions {
  microseconds delay{0};   ///< one way
  microseconds jitter{0};  ///< the delay is drawn evenly from delay ± jitter
  double rate_bps = 0;     ///< bits per second; 0: no limit
  milliseconds queue{0};   ///< what would wait longer than this for the rate is dropped
  /// Share of packets lost; drawn anew from [loss, worst_loss] for every second.
  double loss = 0;
  double worst_loss = 0;
  double overtaking = 0;         ///< share of packets that do not wait for those before them
  milliseconds outage_every{0};  ///< 0: never; from the first packet on, at the end of each period
  milliseconds outage{0};        ///< how long everything is lost then
};

struct LinkCounters {
  std::uint64_t packets = 0;
  std::uint64_t bytes = 0;
  std::uint64_t lost = 0;     ///< by chance, or in an outage
  std::uint64_t dropped = 0;  ///< the queue was full
};

/// Decides when a packet comes out at the other end. Pure: same seed, same calls, same fate.
class Link {
 public:
  Link(const LinkOptions& options, std::uint64_t seed) : options_(options), random_(seed) {}

  /// When a packet of so many bytes, which goes in now, comes out; nothing: never. Calls are in the
  /// order of time.
  std::optional<Instant> Carry(std::size_t bytes, Instant now);

  /// From now on; what is under way is not touched.
  void SetOptions(const LinkOptions& options) { options_ = options; }
  /// Loses everything until told otherwise.
  void Cut(bool is_cut) { is_cut_ = is_cut; }
  const LinkCounters& counters() const { return counters_; }

 private:
  bool IsOut(Instant now) const;
  double LossAt(Instant now);
  double Draw(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }

  LinkOptions options_;
  std::mt19937_64 random_;
  LinkCounters counters_;
  bool is_cut_ = false;
  std::optional<Instant> begin_;
  std::int64_t loss_second_ = -1;
  double loss_ = 0;
  Instant free_;  // when the rate has passed what went in
  Instant last_;  // when the last packet in order comes out
};

}  // namespace waymark::network

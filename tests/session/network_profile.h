// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>

namespace waymark::session::support {

/// How long a network takes for one message after the other, one way: a least delay, a queue that
/// fills and drains, losses, and moments in which nothing gets through.
struct NetworkProfile {
  std::string name;
  double least_s = 0;
  double queue_s = 0;          ///< mean of what queues add
  double queue_lasts_s = 0.1;  ///< how long a queue stays alike
  double loss = 0;             ///< of a message
  double outages_per_s = 0;
  double outage_s = 0;
  bool is_stream = false;  ///< as through a gateway: what is lost is sent again, what follows waits
};

inline NetworkProfile FourG() { return {"4G", 0.045, 0.010, 0.1, 0.02, 0.02, 0.2}; }
inline NetworkProfile ThreeG() { return {"3G", 0.110, 0.040, 0.3, 0.03, 0.03, 0.5}; }
inline NetworkProfile Crowded() { return {"crowded", 0.060, 0.080, 0.3, 0.15, 0.05, 2.0}; }

/// One way through a network, with the same chances each time.
class NetworkPath {
 public:
  NetworkPath(const NetworkProfile& profile, std::uint64_t seed)
      : profile_(profile), random_(seed) {}

  /// When a message arrives that is sent then; nothing when it is lost. Call it in order.
  std::optional<double> ArrivalOf(double sent_s) {
    std::uniform_real_distribution<double> chance(0, 1);
    const double elapsed_s = std::max(0.0, sent_s - last_s_);
    last_s_ = sent_s;
    if (chance(random_) < profile_.outages_per_s * elapsed_s)
      out_until_s_ = sent_s + profile_.outage_s;
    // An exponential that forgets: its mean is queue_s at any moment.
    const double kept = std::exp(-elapsed_s / profile_.queue_lasts_s);
    const double fresh = -std::log(1 - chance(random_)) * profile_.queue_s;
    queue_s_ = kept * queue_s_ + (1 - kept) * fresh * 1.5;
    double arrives_s = std::max(sent_s, out_until_s_) + profile_.least_s + queue_s_;
    const bool is_lost = chance(random_) < profile_.loss;
    if (!profile_.is_stream) {
      if (is_lost || sent_s < out_until_s_) return std::nullopt;
      return arrives_s;
    }
    if (is_lost) arrives_s += 2 * profile_.least_s;  // found out and sent again
    arrives_s = std::max(arrives_s, last_arrival_s_);
    last_arrival_s_ = arrives_s;
    return arrives_s;
  }

 private:
  NetworkProfile profile_;
  std::mt19937_64 random_;
  double last_s_ = 0, queue_s_ = 0, out_until_s_ = -1, last_arrival_s_ = 0;
};

}  // namespace waymark::session::support

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

#include "mapping/base/allowance.h"
#include "session/dds/log_budget.h"

namespace waymark::session::wire {

/// What each of those who speak for themselves may say; what is beyond is dropped.
struct ShareOptions {
  double messages_per_s = 300;           ///< > 0; a phone says some 40
  double bytes_per_s = 8 * 1024 * 1024;  ///< of images and payloads, > 0
};

/// Gives every device on the bus its share of the server's attention, by where it writes: under DDS
/// Security that is where nobody else may. So a device that floods loses what it says itself and
/// nobody else does. Thread-safe.
class Shares {
 public:
  using Time = Allowance::Time;

  explicit Shares(const ShareOptions& options) : options_(options) {}

  /// Whether a message that carries so much may be heard. A gateway's phones have their share
  /// there.
  bool Take(const std::string& partition, std::size_t bytes, Time now);
  /// That were dropped.
  std::uint64_t Throttled() const;

 private:
  struct Share {
    Allowance messages, bytes;
    std::uint64_t dropped = 0;
    Time told{};  // of it
  };

  Share& ShareOf(const std::string& partition, Time now);  // with mutex_ held
  void Tell(const std::string& partition, Share& share, Time now);

  const ShareOptions options_;
  dds::LogBudget log_;
  mutable std::mutex mutex_;
  std::map<std::string, Share> shares_;  // guarded by mutex_; by partition
  std::uint64_t throttled_ = 0;          // guarded by mutex_
};

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>

#include "session/dds/log_budget.h"

namespace waymark::session::dds::internal {

/// Participants that were discovered and are not let in. Cyclone says nothing of one without
/// credentials. Thread-safe.
class Strangers {
 public:
  /// What the GUIDs of a participant and all that it has begin with.
  using Prefix = std::array<std::uint32_t, 3>;
  using Time = std::chrono::steady_clock::time_point;

  /// Learns of participants by one of this process, which owns what does it. Lives longer.
  void WatchFrom(std::int32_t participant);

  void Discover(const Prefix& prefix, Time now);
  void Admit(const Prefix& prefix);
  void Lose(const Prefix& prefix);
  /// Logs each that has been here for longer than it takes to show credentials.
  void Tell(Time now);

 private:
  std::mutex mutex_;
  LogBudget log_;
  std::map<Prefix, Time> waiting_;  // guarded by mutex_; since when
  std::set<Prefix> admitted_;       // guarded by mutex_
};

}  // namespace waymark::session::dds::internal

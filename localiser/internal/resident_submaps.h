// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <optional>

#include "localiser/internal/open_submap.h"
#include "localiser/localiser.h"

namespace waymark::localiser::internal {

/// Submaps in memory, as many as a budget allows; those that were not asked for longest go first.
/// Who asks for one that is not there opens it, and only those who want the same one wait for it.
/// What requests under way hold is not freed before they end, and not counted. Thread-safe.
class ResidentSubmaps {
 public:
  using Opener = std::function<Result<OpenSubmap>()>;

  explicit ResidentSubmaps(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}

  bool Holds(const SubmapId& id) const;
  /// Errors: those of `open`, which is called without any lock; the next who asks tries again.
  Result<OpenSubmap> Get(const SubmapId& id, const Opener& open);
  LocaliserMemory memory() const;

 private:
  struct Entry {
    std::optional<OpenSubmap> submap;  // absent: somebody opens it
    std::size_t bytes = 0;
    std::list<SubmapId>::iterator place;  // in order_, once open
  };

  void KeepBudget();

  const std::size_t budget_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<SubmapId, Entry> entries_;  // guarded by mutex_
  std::list<SubmapId> order_;          // guarded by mutex_; asked for last: first
  LocaliserMemory memory_;             // guarded by mutex_
};

}  // namespace waymark::localiser::internal

// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/resident_submaps.h"

#include <algorithm>
#include <utility>

#include "mapping/base/stopwatch.h"

namespace waymark::localiser::internal {

bool ResidentSubmaps::Holds(const SubmapId& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(id);
  return found != entries_.end() && found->second.submap;
}

Result<OpenSubmap> ResidentSubmaps::Get(const SubmapId& id, const Opener& open) {
  std::unique_lock lock(mutex_);
  for (auto found = entries_.find(id); found != entries_.end(); found = entries_.find(id)) {
    if (found->second.submap) {
      order_.splice(order_.begin(), order_, found->second.place);
      return *found->second.submap;
    }
    changed_.wait(lock);
  }
  entries_.emplace(id, Entry{});
  lock.unlock();
  const Stopwatch watch;
  Result<OpenSubmap> opened = open();
  const double opening_ms = 1e3 * watch.ElapsedS();
  lock.lock();
  if (opened) {
    order_.push_front(id);
    entries_[id] = {*opened, opened->bytes(), order_.begin()};
    ++memory_.openings;
    memory_.opening_ms += opening_ms;
    memory_.resident_bytes += opened->bytes();
    KeepBudget();
    memory_.peak_bytes = std::max(memory_.peak_bytes, memory_.resident_bytes);
  } else {
    entries_.erase(id);
  }
  changed_.notify_all();
  return opened;
}

void ResidentSubmaps::KeepBudget() {
  while (memory_.resident_bytes > budget_bytes_ && !order_.empty()) {
    const auto oldest = entries_.find(order_.back());
    memory_.resident_bytes -= oldest->second.bytes;
    ++memory_.evictions;
    entries_.erase(oldest);
    order_.pop_back();
  }
}

LocaliserMemory ResidentSubmaps::memory() const {
  const std::lock_guard lock(mutex_);
  LocaliserMemory memory = memory_;
  memory.budget_bytes = budget_bytes_;
  memory.resident_submaps = order_.size();
  return memory;
}

}  // namespace waymark::localiser::internal

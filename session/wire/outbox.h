// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "session/wire/traffic.h"

namespace waymark::session::wire {

/// Messages of one slot replace each other while they wait; those without are all delivered.
using Slot = std::uint32_t;
std::optional<Slot> SlotOf(const Upward& message);
std::optional<Slot> SlotOf(const Downward& message);

/// Encoded once, sent to many.
using SharedFrame = std::shared_ptr<const std::vector<std::uint8_t>>;
inline SharedFrame Share(std::vector<std::uint8_t> frame) {
  return std::make_shared<const std::vector<std::uint8_t>>(std::move(frame));
}

/// Frames that wait for a stream which may be slower than what is said: old poses and pings make
/// way for new ones of their kind, everything else waits its turn, up to a bound. One large thing,
/// cut into parts, goes when nothing else waits; a newer one takes the place of what is left of it.
/// Thread-safe.
class Outbox {
 public:
  explicit Outbox(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  enum class Outcome {
    kFirst,   ///< nothing waited before: wake whoever sends
    kQueued,  ///< behind others, or in the place of an older one
    kFull,    ///< dropped
  };
  Outcome Push(SharedFrame frame, std::optional<Slot> slot);

  /// Says whether nothing waited before.
  bool PushParts(std::vector<SharedFrame> parts);
  /// What is left of those parts.
  std::size_t WaitingPartBytes() const;

  /// The next frame, oldest place first, parts last; null when nothing waits.
  SharedFrame Pop();

  void Clear();

 private:
  struct Place {
    SharedFrame frame;
    std::optional<Slot> slot;
  };

  const std::size_t max_bytes_;
  mutable std::mutex mutex_;
  // Guarded by mutex_. References into a deque survive pushing and popping at its ends.
  std::deque<Place> places_;
  std::map<Slot, Place*> by_slot_;
  std::size_t bytes_ = 0;
  std::deque<SharedFrame> parts_;  // bounded by their makers
};

}  // namespace waymark::session::wire

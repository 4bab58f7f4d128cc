// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <iterator>
#include <utility>

#include "session/state/events.h"

namespace waymark::session {

/// Rooms whose anchors have been read, handed on some anchors at a time, lest all other rooms wait
/// for a large one. Thread-compatible.
class RoomLoading {
 public:
  bool IsEmpty() const { return rooms_.empty(); }
  void Add(event::RoomLoaded room) { rooms_.push_back(std::move(room)); }

  /// What to tell the state next. Requires that it is not empty.
  Event Next() {
    constexpr std::ptrdiff_t kAtOnce = 500;
    event::RoomLoaded& room = rooms_.front();
    if (std::ssize(room.anchors) <= kAtOnce) {
      Event last(std::move(room));
      rooms_.pop_front();
      return last;
    }
    const auto first = room.anchors.end() - kAtOnce;
    event::RoomPartLoaded part{room.room,
                               {std::move_iterator(first), std::move_iterator(room.anchors.end())}};
    room.anchors.erase(first, room.anchors.end());
    return part;
  }

 private:
  std::deque<event::RoomLoaded> rooms_;
};

}  // namespace waymark::session

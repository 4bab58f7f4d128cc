// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <unordered_map>
#include <unordered_set>

#include "session/state/messages.h"

namespace waymark::session::recording {

/// Other names for tickets, so that a recording gives nobody a ticket of a living session. A rule
/// that treats equal tickets alike treats their names alike. Thread-compatible.
class TicketNames {
 public:
  /// From now on this ticket has a name.
  void Add(Ticket ticket);
  /// It was given to a device: its name is kept. Of others only the latest 65,536 are.
  void Keep(Ticket ticket) { kept_.insert(ticket); }
  /// Zero, which is nobody's, for those that have none.
  Ticket NameOf(Ticket ticket) const;

 private:
  struct Hash {
    std::size_t operator()(Ticket ticket) const { return static_cast<std::size_t>(ticket); }
  };

  std::unordered_map<Ticket, Ticket, Hash> names_;
  std::unordered_set<Ticket, Hash> kept_;
  std::deque<Ticket> offered_;  // oldest first
  std::uint64_t next_ = 1;
};

}  // namespace waymark::session::recording

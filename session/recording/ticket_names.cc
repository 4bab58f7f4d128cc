// SPDX-License-Identifier: Apache-2.0
#include "session/recording/ticket_names.h"

namespace waymark::session::recording {

void TicketNames::Add(Ticket ticket) {
  constexpr std::size_t kMaxOffered = 65'536;
  if (!names_.try_emplace(ticket, Ticket{next_}).second) return;
  ++next_;
  offered_.push_back(ticket);
  if (offered_.size() <= kMaxOffered) return;
  if (!kept_.contains(offered_.front())) names_.erase(offered_.front());
  offered_.pop_front();
}

Ticket TicketNames::NameOf(Ticket ticket) const {
  const auto found = names_.find(ticket);
  return found == names_.end() ? Ticket{} : found->second;
}

}  // namespace waymark::session::recording

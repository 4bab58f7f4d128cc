// SPDX-License-Identifier: Apache-2.0
// The server goes over to another release.
#include <utility>

#include "session/server/attachments.h"
#include "session/server/internal/server_loop.h"

namespace waymark::session {

// The state says when it goes live.
void Server::Loop::GoOver(Prepared next) {
  const auto& [release, localise] = next_release_.emplace(std::move(next));
  Apply(event::ReleaseSwapped{release->release.epoch,
                              std::shared_ptr<const Placements>(release, &release->placements)});
}

void Server::Loop::Do(effect::GoLive, ServerTime) {
  ++counters_.swaps;
  store_.SetRelease(std::move(next_release_->release));
  pool_.SetLocalise(std::move(next_release_->localise));
  next_release_.reset();
}

}  // namespace waymark::session

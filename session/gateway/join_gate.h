// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "session/keys/token_door.h"

namespace waymark::session::internal {

/// Decides at the door, before anything is opened for a phone, whether it may go on to the server:
/// by its token, and by how often its address has been here. Who guesses must wait: an address may
/// fail ten times at once and then once in ten seconds, which leaves a crowd behind one address
/// alone as long as its tokens are good. Thread-safe.
class JoinGate {
 public:
  using Instant = std::chrono::steady_clock::time_point;

  /// Without a door everybody may pass, at the pace of the addresses: ten seconds' joins at once.
  explicit JoinGate(std::shared_ptr<keys::TokenDoor> door, double joins_per_s = 50)
      : door_(std::move(door)), joins_per_s_(joins_per_s) {}

  /// Why not; nothing when it may. `peer` is "ADDRESS:PORT".
  std::optional<std::string> FindObjection(const Hello& hello, const std::string& peer,
                                           keys::WallTime wall_now, Instant now);

 private:
  struct Visitor {
    double joins_left = 0, failures_left = 0;
    Instant seen;
  };

  Visitor& VisitorOf(const std::string& peer, Instant now);  // with mutex_ held

  const std::shared_ptr<keys::TokenDoor> door_;
  const double joins_per_s_;
  std::mutex mutex_;
  std::map<std::string, Visitor> visitors_;  // guarded by mutex_; by address
  Instant refreshed_;                        // guarded by mutex_
};

}  // namespace waymark::session::internal

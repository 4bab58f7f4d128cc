// SPDX-License-Identifier: Apache-2.0
#include "session/gateway/join_gate.h"

#include <algorithm>

namespace waymark::session::internal {
namespace {

constexpr double kJoinSeconds = 10;  // whose joins may come at once
constexpr double kFailures = 10, kFailuresPerS = 0.1;
constexpr std::size_t kMaxVisitors = 10'000;
constexpr std::chrono::minutes kMemory{2};  // by then both allowances are full again
constexpr std::chrono::seconds kRefreshInterval{1};

}  // namespace

JoinGate::Visitor& JoinGate::VisitorOf(const std::string& peer, Instant now) {
  const std::string address = peer.substr(0, peer.rfind(':'));
  if (visitors_.size() >= kMaxVisitors) {
    std::erase_if(visitors_, [&](const auto& entry) { return now - entry.second.seen > kMemory; });
  }
  // More at once than are remembered share what is left to one.
  const bool is_crowded = visitors_.size() >= kMaxVisitors && !visitors_.contains(address);
  const auto [entry, is_new] = visitors_.try_emplace(
      is_crowded ? "" : address, Visitor{kJoinSeconds * joins_per_s_, kFailures, now});
  Visitor& visitor = entry->second;
  const double elapsed_s = std::max(0.0, Seconds(now - visitor.seen));
  visitor.joins_left =
      std::min(kJoinSeconds * joins_per_s_, visitor.joins_left + joins_per_s_ * elapsed_s);
  visitor.failures_left = std::min(kFailures, visitor.failures_left + kFailuresPerS * elapsed_s);
  visitor.seen = now;
  return visitor;
}

std::optional<std::string> JoinGate::FindObjection(const Hello& hello, const std::string& peer,
                                                   keys::WallTime wall_now, Instant now) {
  const std::lock_guard lock(mutex_);
  Visitor& visitor = VisitorOf(peer, now);
  if (visitor.failures_left < 1 || visitor.joins_left < 1) {
    return "too many attempts from this address; try again in a while";
  }
  --visitor.joins_left;
  if (!door_) return std::nullopt;
  if (now - refreshed_ >= kRefreshInterval) {
    refreshed_ = now;
    (void)door_->Refresh();  // the server sends away who is here already
  }
  std::string refusal = door_->Check(hello, wall_now, ServerTime{}).refusal;
  if (refusal.empty()) return std::nullopt;
  --visitor.failures_left;
  return refusal;
}

}  // namespace waymark::session::internal

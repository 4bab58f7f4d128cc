// SPDX-License-Identifier: Apache-2.0
#include "session/wire/shares.h"

#include "mapping/base/log.h"
#include "session/state/uuid.h"

namespace waymark::session::wire {
namespace {

constexpr std::size_t kMaxShares = 8192;
constexpr std::chrono::seconds kToldAgain{60};

/// Who writes in a partition. It may have chosen it, so only what has a known form is repeated.
std::string SpeakerOf(const std::string& partition) {
  const auto uuid = FindUuid(std::string_view(partition).substr(partition.rfind('.') + 1));
  return uuid ? "device " + FormatUuid(*uuid) : "somebody on the bus";
}

}  // namespace

bool Shares::Take(const std::string& partition, std::size_t bytes, Time now) {
  if (partition.ends_with(".up.gateway")) return true;
  const std::lock_guard lock(mutex_);
  Share& share = ShareOf(partition, now);
  if (share.messages.Take(1, now) && share.bytes.Take(static_cast<double>(bytes), now)) return true;
  ++throttled_;
  ++share.dropped;
  if (now - share.told >= kToldAgain) Tell(partition, share, now);
  return false;
}

void Shares::Tell(const std::string& partition, Share& share, Time now) {
  share.told = now;
  if (!log_.Admit(now)) return;
  LogWarning("{}: says too much; of it is dropped what is beyond its share, so far {} messages",
             SpeakerOf(partition), share.dropped);
}

Shares::Share& Shares::ShareOf(const std::string& partition, Time now) {
  const auto found = shares_.find(partition);
  if (found != shares_.end()) return found->second;
  if (shares_.size() >= kMaxShares) {  // who has all of its share is as if it were new
    std::erase_if(shares_, [&](const auto& entry) {
      return entry.second.messages.IsFull(now) && entry.second.bytes.IsFull(now);
    });
  }
  if (shares_.size() >= kMaxShares) shares_.clear();
  return shares_
      .emplace(partition, Share{.messages = Allowance(options_.messages_per_s, now),
                                .bytes = Allowance(options_.bytes_per_s, now),
                                .told = now - 2 * kToldAgain})
      .first->second;
}

std::uint64_t Shares::Throttled() const {
  const std::lock_guard lock(mutex_);
  return throttled_;
}

}  // namespace waymark::session::wire

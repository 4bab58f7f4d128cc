// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/rate_limit.h"

#include <algorithm>

namespace waymark::content::internal {

double RateLimit::LevelAt(const Bucket& bucket, Time now) const {
  const double passed_s = std::chrono::duration<double>(now - bucket.filled).count();
  return std::min(limits_.max_burst,
                  bucket.level + std::max(0.0, passed_s) * limits_.max_writes_per_second);
}

Result<void> RateLimit::Admit(const std::string& owner, Time now) {
  if (limits_.max_writes_per_second == 0) return {};
  if (buckets_.size() >= forget_at_) Forget(now);
  Bucket& bucket = buckets_.try_emplace(owner, Bucket{limits_.max_burst, now}).first->second;
  bucket.level = LevelAt(bucket, now);
  bucket.filled = now;
  if (bucket.level < 1) {
    return MakeError(ErrorCode::kUnavailable,
                     "owner {}: writes faster than {} per second; try again in {:.2f} s", owner,
                     limits_.max_writes_per_second,
                     (1 - bucket.level) / limits_.max_writes_per_second);
  }
  bucket.level -= 1;
  return {};
}

void RateLimit::Return(const std::string& owner) {
  const auto found = buckets_.find(owner);
  if (found != buckets_.end()) found->second.level += 1;
}

void RateLimit::Forget(Time now) {
  std::erase_if(buckets_,
                [&](const auto& entry) { return LevelAt(entry.second, now) >= limits_.max_burst; });
  forget_at_ = std::max<std::size_t>(1024, 2 * buckets_.size());
}

}  // namespace waymark::content::internal

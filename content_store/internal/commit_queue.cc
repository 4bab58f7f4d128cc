// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/commit_queue.h"

#include <algorithm>
#include <cstddef>

#include "mapping/base/check.h"

namespace waymark::content::internal {
namespace {

constexpr std::size_t kMaxBatch = 64;  // beyond it a commit's sync is no longer what costs

}  // namespace

Result<WriteOutcome> CommitQueue::Run(const Write& write) {
  Waiting mine{&write, std::nullopt};
  std::unique_lock lock(mutex_);
  waiting_.push_back(&mine);
  while (true) {
    changed_.wait(lock, [&] { return mine.outcome.has_value() || !is_committing_; });
    if (mine.outcome) return *std::move(mine.outcome);

    const auto count = static_cast<std::ptrdiff_t>(std::min(waiting_.size(), kMaxBatch));
    const std::vector<Waiting*> batch(waiting_.begin(), waiting_.begin() + count);
    waiting_.erase(waiting_.begin(), waiting_.begin() + count);
    std::vector<const Write*> writes;
    for (const Waiting* waiting : batch) writes.push_back(waiting->write);
    is_committing_ = true;
    lock.unlock();
    auto outcomes = commit_(writes);
    CHECK(outcomes.size() == batch.size());
    lock.lock();
    is_committing_ = false;
    for (std::size_t i = 0; i < batch.size(); ++i) batch[i]->outcome = std::move(outcomes[i]);
    changed_.notify_all();
  }
}

}  // namespace waymark::content::internal

// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/commit_queue.h"

#include <cstddef>
#include <iterator>

#include "mapping/base/check.h"

namespace waymark::content::internal {
namespace {

constexpr std::size_t kMaxBatch = 512;  // beyond it a commit's sync is no longer what costs

}  // namespace

std::vector<Result<WriteOutcome>> CommitQueue::Run(std::span<const WriteRequest> requests) {
  Job mine{.requests = requests};
  std::unique_lock lock(mutex_);
  waiting_.push_back(&mine);
  mine.changed.wait(lock,
                    [&] { return mine.is_done || (!is_committing_ && waiting_.front() == &mine); });
  if (mine.is_done) return std::move(mine.outcomes);

  const std::vector<Job*> batch = TakeBatch();
  is_committing_ = true;
  lock.unlock();
  CommitBatch(batch);
  lock.lock();
  is_committing_ = false;
  for (Job* job : batch) {
    job->is_done = true;
    job->changed.notify_one();
  }
  if (!waiting_.empty()) waiting_.front()->changed.notify_one();
  return std::move(mine.outcomes);
}

std::vector<CommitQueue::Job*> CommitQueue::TakeBatch() {
  std::vector<Job*> batch;
  std::size_t size = 0;
  while (!waiting_.empty() &&
         (batch.empty() || size + waiting_.front()->requests.size() <= kMaxBatch)) {
    size += waiting_.front()->requests.size();
    batch.push_back(waiting_.front());
    waiting_.pop_front();
  }
  return batch;
}

void CommitQueue::CommitBatch(const std::vector<Job*>& batch) {
  std::vector<const WriteRequest*> requests;
  for (const Job* job : batch) {
    for (const WriteRequest& request : job->requests) requests.push_back(&request);
  }
  std::vector<Result<WriteOutcome>> outcomes = commit_(requests);
  CHECK(outcomes.size() == requests.size());
  auto next = std::make_move_iterator(outcomes.begin());
  for (Job* job : batch) {
    const auto end = next + static_cast<std::ptrdiff_t>(job->requests.size());
    job->outcomes.assign(next, end);
    next = end;
  }
}

}  // namespace waymark::content::internal

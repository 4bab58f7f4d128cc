// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "content_store/internal/write_batch.h"

namespace waymark::content::internal {

/// Lets callers that write at the same moment share one commit, whose sync to disk is what a write
/// costs. The first caller commits for all who wait; nobody waits for company, and no thread is
/// kept for it. Thread-safe.
class CommitQueue {
 public:
  /// Applies the requests in order in one transaction and returns their outcomes, committed.
  using Commit =
      std::function<std::vector<Result<WriteOutcome>>(const std::vector<const WriteRequest*>&)>;

  explicit CommitQueue(Commit commit) : commit_(std::move(commit)) {}

  /// Returns when the requests are committed, or have failed. They are one transaction, and those
  /// of one thread keep their order.
  std::vector<Result<WriteOutcome>> Run(std::span<const WriteRequest> requests);

 private:
  struct Job {
    std::span<const WriteRequest> requests;
    std::vector<Result<WriteOutcome>> outcomes{};
    bool is_done = false;
    std::condition_variable changed{};
  };

  std::vector<Job*> TakeBatch();
  void CommitBatch(const std::vector<Job*>& batch);

  const Commit commit_;  // called by one thread at a time
  std::mutex mutex_;
  std::deque<Job*> waiting_;    // guarded by mutex_; the front one commits next
  bool is_committing_ = false;  // guarded by mutex_
};

}  // namespace waymark::content::internal

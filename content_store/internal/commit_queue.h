// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "content_store/anchor_store.h"
#include "mapping/base/result.h"

namespace waymark::content::internal {

/// Lets callers that write at the same moment share one commit, whose sync to disk is what a write
/// costs. The first caller commits for all who wait; nobody waits for company, and no thread is
/// kept for it. Thread-safe.
class CommitQueue {
 public:
  /// One write, run inside a transaction. If it fails by returning an error it has written nothing;
  /// if it throws, the whole batch is undone.
  using Write = std::function<Result<WriteOutcome>()>;
  /// Runs the writes in order in one transaction and returns their outcomes, committed.
  using Commit = std::function<std::vector<Result<WriteOutcome>>(const std::vector<const Write*>&)>;

  explicit CommitQueue(Commit commit) : commit_(std::move(commit)) {}

  /// Returns when the write is committed, or has failed. Writes of one thread keep their order.
  Result<WriteOutcome> Run(const Write& write);

 private:
  struct Waiting {
    const Write* write;
    std::optional<Result<WriteOutcome>> outcome;
  };

  const Commit commit_;  // called by one thread at a time
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting*> waiting_;  // guarded by mutex_
  bool is_committing_ = false;    // guarded by mutex_
};

}  // namespace waymark::content::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/last_commit.h"
#include "content_store/internal/rate_limit.h"
#include "content_store/internal/write_batch.h"

namespace waymark::content::internal {

/// The connection through which a store writes, opened anew when it was lost. Thread-compatible.
class StoreWriter {
 public:
  StoreWriter(AnchorDatabase& database, const StoreOptions& options,
              std::unique_ptr<AnchorTables> connection)
      : database_(database), options_(options), connection_(std::move(connection)) {}

  /// Applies the requests in order in one transaction and returns their outcomes, committed.
  std::vector<Result<WriteOutcome>> Commit(const std::vector<const WriteRequest*>& requests);
  /// Whether the latest Commit changed anything.
  bool has_written() const { return has_written_; }

 private:
  Result<void> Prepare();
  Result<std::vector<Result<WriteOutcome>>> CommitOn(
      const std::optional<WriteBasis>& foreseen, const std::vector<const WriteRequest*>& requests);

  AnchorDatabase& database_;
  const StoreOptions& options_;
  std::unique_ptr<AnchorTables> connection_;  // absent: it was lost
  bool is_untrusted_ = false;
  bool has_written_ = false;
  RateLimit rates_{options_.limits};
  LastCommit last_commit_;
};

}  // namespace waymark::content::internal

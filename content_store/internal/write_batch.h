// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "content_store/anchor_store.h"
#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/rate_limit.h"

namespace waymark::content::internal {

enum class WriteKind { kCreate, kUpdate, kMove, kDelete };

/// One write as a caller asked for it, its values within their limits.
struct WriteRequest {
  WriteKind kind;
  AnchorRecord record;  ///< kMove: only the fields of AnchorMove; kDelete: only room and id
  std::uint64_t expected_revision = 0;
  bool is_limited = true;  ///< counts in its owner's rate
};

/// What some writes make of the store: decided one after the other in memory, read and written in
/// bulk, so that the number of statements does not grow with the number of writes. Lives inside one
/// transaction; throws what SOCI throws. Thread-compatible.
class WriteBatch {
 public:
  WriteBatch(AnchorTables& tables, const StoreLimits& limits, RateLimit& rates, RateLimit::Time now)
      : tables_(tables), limits_(limits), rates_(rates), now_(now) {}

  std::vector<Result<WriteOutcome>> Run(const std::vector<const WriteRequest*>& requests);

  /// The store's revision afterwards.
  std::uint64_t revision() const { return revision_; }
  bool has_written() const { return !rows_.empty(); }

 private:
  using Present = Result<std::optional<AnchorState>>;  // an error: its state is damaged

  void LoadPresent(const std::vector<const WriteRequest*>& requests);
  void LoadUsage(const std::vector<const WriteRequest*>& requests);
  Result<WriteOutcome> Apply(const WriteRequest& request);
  Result<WriteOutcome> Create(const WriteRequest& request, std::optional<AnchorState>& present);
  Result<WriteOutcome> Change(const WriteRequest& request, AnchorState& present);
  Result<void> Account(const std::string& room, const std::string& owner, std::int64_t anchors,
                       std::int64_t bytes);
  AnchorRecord Append(std::optional<AnchorState>& present, AnchorState next);
  void Store();

  AnchorTables& tables_;
  const StoreLimits& limits_;
  RateLimit& rates_;
  const RateLimit::Time now_;
  std::uint64_t revision_ = 0;
  std::map<AnchorKey, Present> present_;  // as of the writes applied so far
  std::map<OwnerKey, Usage> usage_;
  std::set<OwnerKey> changed_usage_;
  std::set<AnchorKey> changed_;
  std::vector<LogRow> rows_;
};

}  // namespace waymark::content::internal

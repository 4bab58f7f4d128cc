// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "content_store/anchor_store.h"
#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/rate_limit.h"

namespace waymark::content::internal {

enum class WriteKind { kCreate, kUpdate, kMove, kDelete };

/// One write as a caller asked for it, its values within their limits.
struct WriteRequest {
  WriteKind kind;
  const AnchorRecord& record;  ///< kMove: the fields of AnchorMove; kDelete: room and id; borrowed
  std::uint64_t expected_revision = 0;
  bool is_limited = true;  ///< counts in its owner's rate
};

/// What some writes make of the store: decided one after the other in memory, read and written in
/// bulk, so that the number of statements does not grow with the number of writes. Lives inside one
/// transaction; throws what SOCI throws. Thread-compatible.
class WriteBatch {
 public:
  /// `foreseen`: decide on this, and have the transaction fail if it is not so.
  WriteBatch(AnchorTables& tables, const StoreLimits& limits, RateLimit& rates, RateLimit::Time now,
             std::optional<WriteBasis> foreseen = std::nullopt)
      : tables_(tables),
        limits_(limits),
        rates_(rates),
        now_(now),
        foreseen_(std::move(foreseen)) {}

  /// Errors: Conflict if what was foreseen cannot decide: a refusal may be a repeated creation.
  Result<std::vector<Result<WriteOutcome>>> Run(const std::vector<const WriteRequest*>& requests);
  /// Nothing of it was committed, and it is tried again: its writes count in no owner's rate.
  void ReturnRates();

  /// The store's revision before and afterwards.
  std::uint64_t basis_revision() const { return basis_revision_; }
  std::uint64_t revision() const { return revision_; }
  /// Of the owners in question, afterwards.
  const std::map<OwnerKey, Usage>& usage() const { return usage_; }
  bool has_written() const { return !rows_.empty(); }

 private:
  /// An anchor that is asked for, as of the writes applied so far.
  struct Slot {
    Result<std::optional<AnchorState>> present = std::optional<AnchorState>();  // or it is damaged
    bool is_new = false;      // the index never had it
    bool is_changed = false;  // by one of these writes
  };

  Error NotAsForeseen() const;
  void LoadBasis(const std::vector<const WriteRequest*>& requests);
  void LoadOwners(const std::vector<const WriteRequest*>& requests);
  Result<WriteOutcome> Apply(const WriteRequest& request, Slot& slot);
  Result<WriteOutcome> Create(const WriteRequest& request, Slot& slot);
  Result<WriteOutcome> Change(const WriteRequest& request, Slot& slot);
  Result<void> Admit(const WriteRequest& request, const std::string& owner);
  Result<void> Account(const std::string& room, const std::string& owner, std::int64_t anchors,
                       std::int64_t bytes);
  AnchorRecord Append(Slot& slot, AnchorState next);
  void Store();

  AnchorTables& tables_;
  const StoreLimits& limits_;
  RateLimit& rates_;
  const RateLimit::Time now_;
  const std::optional<WriteBasis> foreseen_;
  std::uint64_t basis_revision_ = 0, revision_ = 0;
  std::vector<std::string> admitted_;  // owners, once for each write
  std::map<AnchorKey, Slot> slots_;
  std::vector<Slot*> asked_;         // by the requests, in their order
  std::set<OwnerKey> known_owners_;  // whose usage is in usage_, if they have any
  std::map<OwnerKey, Usage> usage_;
  std::set<OwnerKey> changed_usage_;
  std::vector<LogRow> rows_;
};

}  // namespace waymark::content::internal

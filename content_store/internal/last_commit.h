// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/write_batch.h"

namespace waymark::content::internal {

/// What the last commit of this store left behind. While nobody else writes, the next creations
/// can be decided on it without asking the database, which only has to say that it is still so
/// (AnchorTables::Require). Thread-compatible.
class LastCommit {
 public:
  /// What to decide these requests on: that all are creations of new anchors, by owners whose usage
  /// is known. Absent: ask the database, also when others wrote between the last two commits.
  std::optional<WriteBasis> Foresee(const std::vector<const WriteRequest*>& requests) const;

  /// A batch was committed.
  void Remember(const WriteBatch& batch);

 private:
  std::uint64_t latest_ = 0;
  bool is_alone_ = false;  // the last commit found what the one before it had left
  std::map<OwnerKey, Usage> usage_;
};

}  // namespace waymark::content::internal

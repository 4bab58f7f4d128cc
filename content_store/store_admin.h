// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "mapping/base/result.h"

namespace waymark::content {

struct CompactionReport {
  std::uint64_t states_before = 0;
  std::uint64_t states_after = 0;
  std::uint64_t compacted_through = 0;  ///< up to here only each anchor's latest state is left
};

/// Removes superseded states older than the latest `keep_revisions` revisions and gives the room
/// back. Anchors, revisions and spent ids stay. Servers may go on meanwhile; a reader of changes
/// who is farther behind then meets only the latest change of each anchor. Works in small
/// transactions, so a killed compaction has done a part and can be repeated.
/// Errors: those of OpenStore.
Result<CompactionReport> CompactStore(const std::string& location, std::uint64_t keep_revisions);

/// Brings a store to the present schema in one transaction and says whether that was needed.
/// Errors: those of OpenStore.
Result<bool> MigrateStore(const std::string& location);

}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/base/result.h"

namespace waymark::mapping {

struct PruneRequest {
  std::filesystem::path map_folder = {};
  std::size_t keep = 10;      ///< newest releases that stay beside the live one, >= 1
  bool is_rehearsal = false;  ///< say what would go, and delete nothing
};

/// What went, or would go.
struct PruneReport {
  std::vector<std::uint64_t> releases;
  std::vector<SubmapId> submaps;
  std::vector<ExperienceId> experiences;  ///< all of whose submaps went
  std::size_t other_files = 0;            ///< tasks, decisions, features, temporary files
  std::uint64_t bytes = 0;                ///< of all of them
};

/// Deletes releases but the live one and the newest ones; submaps that then no release holds;
/// experiences that are so left without any submap; and what no plan, index or release names: tasks
/// of earlier plans, features made with earlier options, temporary files and submaps of killed
/// processes that are more than an hour old. What is built but not yet released stays, and so do
/// experiences that were refused: RemoveFromMap takes those out. So a map's size is that of what
/// the kept releases hold. A pruned submap of an experience that is still there is built again when
/// the experience is added again. Killed in between, the next call completes it.
/// Errors: InvalidArgument (keep), NotFound (no such map), Conflict (another writer), Corrupt,
/// Unavailable (storage).
Result<PruneReport> PruneMap(const PruneRequest& request);

}  // namespace waymark::mapping

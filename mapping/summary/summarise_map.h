// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mapping/base/parallel.h"
#include "mapping/store/map_directory.h"
#include "mapping/summary/summarise.h"

namespace waymark::mapping {

/// What one submap was and is now.
struct SummarisedSubmap {
  SubmapId before, after;
  std::size_t bytes_before = 0, bytes_after = 0;
  std::size_t landmarks_before = 0, landmarks_after = 0;
  std::size_t descriptors_before = 0, descriptors_after = 0;
};

/// Writes a release of a map as a map of its own whose submaps are summaries, and deploys it. Same
/// map id, origin, epoch and placement; submaps have other ids, because they have other content.
/// Errors: those of MapDirectory and DecodeSubmap; Conflict when `out` holds something already.
Result<std::vector<SummarisedSubmap>> SummariseMap(const MapDirectory& map, const Release& release,
                                                   const std::filesystem::path& out,
                                                   const SummaryOptions& options,
                                                   const Parallelism& parallelism);

}  // namespace waymark::mapping

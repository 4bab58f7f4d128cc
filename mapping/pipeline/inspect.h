// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

/// What a map knows of one experience.
struct ExperienceSummary {
  ExperienceId id;
  std::size_t images = 0;    ///< usable ones
  std::size_t unusable = 0;  ///< could not be decoded
  std::size_t thinned_out = 0;
  std::size_t undecided = 0;          ///< planned submaps that are not built yet
  std::vector<SubmapReport> submaps;  ///< decided ones
};

/// Every experience of a map that has a plan, sorted by id.
/// Errors: NotFound (no map), Corrupt.
Result<std::vector<ExperienceSummary>> InspectExperiences(const std::filesystem::path& map_folder);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "mapping/pipeline/internal/plan.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {

/// Submaps of the live release; none before the first.
Result<std::set<SubmapId>> LoadLiveSubmaps(const MapDirectory& map);

/// Submaps of any stored release, live or not.
Result<std::set<SubmapId>> LoadReleasedSubmaps(const MapDirectory& map);

/// A task with what became of it.
struct DecidedTask {
  std::string task;
  Decision decision;
};

/// All decisions in an experience's folder, by task; also those of plans that it no longer has.
Result<std::vector<DecidedTask>> LoadDecisions(const std::filesystem::path& experience_folder);

/// Submaps that were ever built from an experience and whose decision is still there.
Result<std::set<SubmapId>> ListOwnSubmaps(const std::filesystem::path& experience_folder);

}  // namespace waymark::mapping

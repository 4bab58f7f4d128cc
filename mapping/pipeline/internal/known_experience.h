// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>

#include "mapping/experience/experience.h"
#include "mapping/pipeline/internal/run.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {

/// What the map already holds under an experience's name.
enum class Known { kNo, kUnfinished, kLive };

/// Compares the recording's content, not its name alone; `live` are the live release's submaps.
/// Errors: Conflict (an experience of this name with other content), those of storage.
Result<Known> FindKnown(const MapDirectory& map, const Experience& experience,
                        const std::set<SubmapId>& live, const Parallelism& parallelism, Run& run);

}  // namespace waymark::mapping

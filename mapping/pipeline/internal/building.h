// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/pipeline/internal/planning.h"
#include "mapping/pipeline/internal/run.h"

namespace waymark::mapping {

/// Builds one planned submap: pairs, matches, structure from motion, verification, assembly; stores
/// the submap, then the decision. A task with a decision is not built again.
/// Errors: those of LoadTaskInput and of storage; a subset that cannot be reconstructed is a
/// decision, not an error.
Result<SubmapReport> BuildTask(const MapDirectory& map, const ExperienceId& experience,
                               const std::string& task, const Parallelism& parallelism, Run& run);

/// What a caller of the pipeline is told of a decision.
SubmapReport ReportOf(const std::string& task, const Decision& decision, bool was_built_before);

}  // namespace waymark::mapping

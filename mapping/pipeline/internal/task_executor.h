// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/pipeline/internal/run.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {

/// Tasks of one experience that have no decision yet.
struct PendingTasks {
  ExperienceId experience;
  std::vector<std::string> tasks;
};

/// Builds pending tasks with the threads of this process, several tasks at once.
/// Errors: those of BuildTask; Unavailable when stopped.
Result<void> BuildHere(const MapDirectory& map, const PendingTasks& pending,
                       const Parallelism& parallelism, Run& run);

/// Builds pending tasks as one array of Slurm jobs, each of which runs `build-submap`, and returns
/// when all are decided. Slurm's word is not taken for it: a task is done when its decision is in
/// the map, and those that end without one are submitted again, up to `options.rounds` times.
/// When stopped, the jobs are cancelled; when all is decided, what jobs left in the map is deleted.
/// Errors: Unavailable (no Slurm, tasks without a decision after all rounds, with the end of one
/// job's log; stopped).
Result<void> BuildWithSlurm(const MapDirectory& map, const PendingTasks& pending,
                            const SlurmOptions& options, Run& run);

/// Submits pending tasks and a job that resumes the run when theirs have ended; returns its id. The
/// map must not be locked: that job may begin at once.
/// Errors: Unavailable (no Slurm; tasks without a decision after all rounds).
Result<std::string> SubmitToSlurm(const MapDirectory& map, const PendingTasks& pending,
                                  const SlurmOptions& options);

}  // namespace waymark::mapping

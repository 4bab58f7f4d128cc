// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "mapping/pipeline/internal/building.h"
#include "mapping/pipeline/internal/task_executor.h"

namespace waymark::mapping {

Result<void> BuildHere(const MapDirectory& map, const PendingTasks& pending,
                       const Parallelism& parallelism, Run& run) {
  const std::size_t threads = parallelism.ThreadCount();
  const std::size_t workers = std::clamp<std::size_t>(pending.tasks.size(), 1, threads);
  const Parallelism outer{static_cast<int>(workers)};
  const Parallelism inner{static_cast<int>(std::max<std::size_t>(1, threads / workers))};
  std::vector<Result<void>> outcomes(pending.tasks.size());
  StageCounter counter(run, PipelineStage::kSubmaps, pending.experience.text(),
                       pending.tasks.size());
  ParallelFor(pending.tasks.size(), outer, [&](std::size_t i) {
    if (run.ShouldStop()) {
      outcomes[i] = Run::Stopped();
      return;
    }
    const auto built = BuildTask(map, pending.experience, pending.tasks[i], inner, run);
    if (built) {
      counter.Add();
    } else {
      outcomes[i] = built.error();
    }
  });
  for (const auto& outcome : outcomes) WAYMARK_TRY(outcome);
  return {};
}

}  // namespace waymark::mapping

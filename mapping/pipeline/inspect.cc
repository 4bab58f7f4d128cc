// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/inspect.h"

#include <utility>

#include "mapping/pipeline/internal/planning.h"

namespace waymark::mapping {

Result<std::vector<ExperienceSummary>> InspectExperiences(const std::filesystem::path& map_folder) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(map_folder));
  WAYMARK_TRY_ASSIGN(const std::vector<ExperienceId> ids, ListPlannedExperiences(map));
  std::vector<ExperienceSummary> summaries;
  for (const ExperienceId& id : ids) {
    const std::filesystem::path folder = map.ExperienceFolder(id);
    WAYMARK_TRY_ASSIGN(const ExperienceIndex index, LoadIndex(folder));
    WAYMARK_TRY_ASSIGN(const std::optional<Plan> plan, LoadPlan(folder));
    if (!plan) continue;
    ExperienceSummary summary{.id = id,
                              .images = index.images.size(),
                              .unusable = index.unusable.size(),
                              .thinned_out = plan->thinned_out.size(),
                              .submaps = {}};
    for (const std::string& task : plan->tasks) {
      WAYMARK_TRY_ASSIGN(const std::optional<Decision> decision, LoadDecision(folder, task));
      if (!decision) {
        ++summary.undecided;
        continue;
      }
      summary.submaps.push_back({.task = task,
                                 .id = decision->submap,
                                 .was_built_before = true,
                                 .verdict = decision->verdict,
                                 .images = decision->images,
                                 .landmarks = decision->landmarks});
    }
    summaries.push_back(std::move(summary));
  }
  return summaries;
}

}  // namespace waymark::mapping

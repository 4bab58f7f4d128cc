// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/known_experience.h"

#include "mapping/pipeline/internal/indexing.h"
#include "mapping/pipeline/internal/planning.h"

namespace waymark::mapping {
namespace {

/// Whether all of an experience's submaps are decided and those accepted are live.
Result<bool> IsInRelease(const MapDirectory& map, const ExperienceId& id,
                         const std::set<SubmapId>& live) {
  const std::filesystem::path folder = map.ExperienceFolder(id);
  WAYMARK_TRY_ASSIGN(const std::optional<Plan> plan, LoadPlan(folder));
  if (!plan) return false;
  bool any_accepted = false;
  for (const std::string& task : plan->tasks) {
    WAYMARK_TRY_ASSIGN(const std::optional<Decision> decision, LoadDecision(folder, task));
    if (!decision) return false;
    if (!decision->submap) continue;
    if (!live.contains(*decision->submap)) return false;
    any_accepted = true;
  }
  return any_accepted;
}

}  // namespace

Result<Known> FindKnown(const MapDirectory& map, const Experience& experience,
                        const std::set<SubmapId>& live, const Parallelism& parallelism, Run& run) {
  const auto index = LoadIndex(map.ExperienceFolder(experience.id));
  if (!index && index.error().code == ErrorCode::kNotFound) return Known::kNo;
  if (!index) return index.error();
  WAYMARK_TRY_ASSIGN(const std::string content, HashRecording(experience, parallelism, run));
  if (content != index->content) {
    return MakeError(
        ErrorCode::kConflict,
        "experience {}: the map holds one of this name with other content; rename the "
        "folder to add it as another experience, or remove and prune the old one first",
        experience.id.text());
  }
  WAYMARK_TRY_ASSIGN(const bool is_live, IsInRelease(map, experience.id, live));
  return is_live ? Known::kLive : Known::kUnfinished;
}

}  // namespace waymark::mapping

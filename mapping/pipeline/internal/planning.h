// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>

#include "mapping/pipeline/internal/plan.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {

/// Cuts an experience into tasks, borrowing from every other experience that has a plan, and
/// stores tasks, then plan. Images whose submap was removed, so that a stored release holds it and
/// `in_map` does not, are not borrowed. A plan made with the same options is kept as it is, so that
/// a run that resumes finds its tasks again, unless it borrows from what is no longer there.
/// Errors: those of SplitExperience and of storage.
Result<Plan> PlanExperience(const MapDirectory& map, const ExperienceIndex& index,
                            const std::set<SubmapId>& in_map, const PipelineOptions& options);

/// Errors: NotFound, those of DecodeTask, naming the file.
Result<SubmapTask> LoadTask(const std::filesystem::path& experience_folder,
                            const std::string& task);

/// nullopt: not planned yet.
Result<std::optional<Plan>> LoadPlan(const std::filesystem::path& experience_folder);

/// nullopt: not decided yet.
Result<std::optional<Decision>> LoadDecision(const std::filesystem::path& experience_folder,
                                             const std::string& task);

/// Ids of all experiences of a map that have a plan, sorted.
Result<std::vector<ExperienceId>> ListPlannedExperiences(const MapDirectory& map);

}  // namespace waymark::mapping

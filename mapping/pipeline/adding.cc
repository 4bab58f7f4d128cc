// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "mapping/base/content_hash.h"
#include "mapping/base/stopwatch.h"
#include "mapping/experience/kapture.h"
#include "mapping/pipeline/internal/building.h"
#include "mapping/pipeline/internal/index_times.h"
#include "mapping/pipeline/internal/indexing.h"
#include "mapping/pipeline/internal/left_out.h"
#include "mapping/pipeline/internal/membership.h"
#include "mapping/pipeline/internal/options_codec.h"
#include "mapping/pipeline/internal/releasing.h"
#include "mapping/pipeline/internal/task_executor.h"
#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

Result<std::vector<Experience>> LoadAll(std::span<const fs::path> folders) {
  std::vector<Experience> experiences;
  std::set<ExperienceId> seen;
  for (const fs::path& folder : folders) {
    WAYMARK_TRY_ASSIGN(Experience experience, LoadKapture(folder));
    if (!seen.insert(experience.id).second) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "experience {}: given twice; the folder's name is the experience's id",
                       experience.id.text());
    }
    experiences.push_back(std::move(experience));
  }
  if (experiences.empty()) {
    return MakeError(ErrorCode::kInvalidArgument, "no experience was given");
  }
  return experiences;
}

/// A UUID of the custom version 8, made from what the map is made from.
std::string NameMap(const Experience& first, std::string_view created_utc) {
  std::string hash = ContentHash(fmt::format("{} {}", first.id.text(), created_utc));
  hash[12] = '8';
  hash[16] = 'a';
  return fmt::format("{}-{}-{}-{}-{}", hash.substr(0, 8), hash.substr(8, 4), hash.substr(12, 4),
                     hash.substr(16, 4), hash.substr(20, 12));
}

Result<MapDirectory> OpenOrCreate(const AddRequest& request,
                                  std::span<const Experience> experiences) {
  auto opened = MapDirectory::Open(request.map_folder);
  if (opened.ok() || opened.error().code != ErrorCode::kNotFound) return opened;
  MapDescription description{.id = NameMap(experiences.front(), request.created_utc),
                             .origin = {},
                             .is_geo_aligned = false,
                             .options_json = EncodeBuildOptions(request.options)};
  for (const Experience& experience : experiences) {
    if (experience.gnss.empty()) continue;
    description.origin = experience.gnss.front().place;
    description.is_geo_aligned = true;
    break;
  }
  return MapDirectory::Create(request.map_folder, description);
}

/// Whether all of an experience's submaps are decided and those accepted are live.
Result<bool> IsInRelease(const MapDirectory& map, const ExperienceId& id,
                         const std::set<SubmapId>& live) {
  const fs::path folder = map.ExperienceFolder(id);
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

/// What the map already holds under an experience's name.
enum class Known { kNo, kUnfinished, kLive };

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

/// Builds those tasks of a plan that have no decision; returns what became of all of them.
Result<std::vector<SubmapReport>> BuildPlan(const MapDirectory& map, const ExperienceId& id,
                                            const Plan& plan, const AddRequest& request, Run& run) {
  const fs::path folder = map.ExperienceFolder(id);
  PendingTasks pending{.experience = id, .tasks = {}};
  for (const std::string& task : plan.tasks) {
    WAYMARK_TRY_ASSIGN(const std::optional<Decision> decision, LoadDecision(folder, task));
    if (!decision) pending.tasks.push_back(task);
  }
  if (request.slurm && !pending.tasks.empty()) {
    WAYMARK_TRY(BuildWithSlurm(map, pending, *request.slurm, run));
  } else {
    WAYMARK_TRY(BuildHere(map, pending, request.options.parallelism, run));
  }
  std::vector<SubmapReport> reports;
  for (const std::string& task : plan.tasks) {
    WAYMARK_TRY_ASSIGN(const std::optional<Decision> decision, LoadDecision(folder, task));
    CHECK(decision.has_value(), "task {} was built", task);
    const bool is_new = std::ranges::find(pending.tasks, task) != pending.tasks.end();
    reports.push_back(ReportOf(task, *decision, !is_new));
  }
  return reports;
}

/// Takes one experience to decided submaps; those accepted join `submaps`, and what was built from
/// it before in another way leaves.
Result<void> AddOne(const MapDirectory& map, const Experience& experience,
                    const AddRequest& request, Run& run, std::set<SubmapId>& submaps,
                    AddReport& report) {
  const Parallelism& parallelism = request.options.parallelism;
  Stopwatch watch;
  IndexTimes times{.features_threads = static_cast<int>(parallelism.ThreadCount())};
  WAYMARK_TRY_ASSIGN(const ExperienceIndex index,
                     IndexExperience(experience, TangentPlane(map.description().origin),
                                     map.ExperienceFolder(experience.id), request.options.features,
                                     parallelism, run));
  times.features_s = watch.Lap();
  WAYMARK_TRY_ASSIGN(const Plan plan, PlanExperience(map, index, submaps, request.options));
  times.split_s = watch.Lap();
  WAYMARK_TRY(AddIndexTimes(map.ExperienceFolder(experience.id), times));
  if (request.until == AddUntil::kPlan) {
    for (const std::string& task : plan.tasks) {
      report.submaps.push_back({.task = task, .id = {}, .verdict = "planned"});
    }
    return {};
  }
  WAYMARK_TRY_ASSIGN(std::vector<SubmapReport> built,
                     BuildPlan(map, experience.id, plan, request, run));
  std::set<SubmapId> accepted;
  for (SubmapReport& submap : built) {
    if (submap.id) accepted.insert(*submap.id);
    report.submaps.push_back(std::move(submap));
  }
  WAYMARK_TRY_ASSIGN(const auto left_out, ListLeftOut(map, index, plan));
  report.left_out.insert(report.left_out.end(), left_out.begin(), left_out.end());
  (accepted.empty() ? report.rejected : report.added).push_back(experience.id);
  if (accepted.empty()) return {};
  WAYMARK_TRY_ASSIGN(const auto built_ever, ListOwnSubmaps(map.ExperienceFolder(experience.id)));
  for (const SubmapId& id : built_ever) submaps.erase(id);
  submaps.insert(accepted.begin(), accepted.end());
  return {};
}

}  // namespace

Result<AddReport> AddExperiences(const AddRequest& request, const PipelineObserver& observer) {
  WAYMARK_TRY(request.options.Validate());
  if (request.slurm) WAYMARK_TRY(request.slurm->Validate());
  WAYMARK_TRY_ASSIGN(const std::vector<Experience> experiences,
                     LoadAll(request.experience_folders));
  WAYMARK_TRY_ASSIGN(const MapDirectory map, OpenOrCreate(request, experiences));
  WAYMARK_TRY_ASSIGN(const FileLock lock, map.LockForWriting());
  WAYMARK_TRY_ASSIGN(const std::set<SubmapId> live, LoadLiveSubmaps(map));

  Run run(observer);
  AddReport report;
  report.is_geo_aligned = map.description().is_geo_aligned;
  std::set<SubmapId> submaps = live;
  for (const Experience& experience : experiences) {
    WAYMARK_TRY_ASSIGN(const Known known,
                       FindKnown(map, experience, live, request.options.parallelism, run));
    if (known == Known::kLive) {
      report.already_in_map.push_back(experience.id);
      continue;
    }
    WAYMARK_TRY(AddOne(map, experience, request, run, submaps, report));
  }
  if (submaps == live) return report;

  FusionOptions fusion = request.options.fusion;
  fusion.parallelism = request.options.parallelism;
  WAYMARK_TRY_ASSIGN(NewRelease release, ReleaseSubmaps(map, submaps, fusion, request.created_utc,
                                                        ReleaseUntil::kLive, run));
  report.epoch = release.epoch;
  report.unplaced = std::move(release.unplaced);
  report.overlap_rms_m = release.overlap_rms_m;
  report.gnss_rms_m = release.gnss_rms_m;
  return report;
}

Result<SubmapReport> BuildSubmap(const fs::path& map_folder, const std::string& task,
                                 const Parallelism& parallelism, const PipelineObserver& observer) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(map_folder));
  WAYMARK_TRY_ASSIGN(const std::vector<ExperienceId> planned, ListPlannedExperiences(map));
  for (const ExperienceId& id : planned) {
    WAYMARK_TRY_ASSIGN(const std::optional<Plan> plan, LoadPlan(map.ExperienceFolder(id)));
    if (!plan || std::ranges::find(plan->tasks, task) == plan->tasks.end()) continue;
    Run run(observer);
    return BuildTask(map, id, task, parallelism, run);
  }
  return MakeError(ErrorCode::kNotFound, "{}: no submap {} is planned", map_folder.string(), task);
}

}  // namespace waymark::mapping

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
#include "mapping/pipeline/internal/known_experience.h"
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

/// Those of a plan's tasks that have no decision.
Result<PendingTasks> FindPending(const MapDirectory& map, const ExperienceId& id,
                                 const Plan& plan) {
  PendingTasks pending{.experience = id, .tasks = {}};
  for (const std::string& task : plan.tasks) {
    WAYMARK_TRY_ASSIGN(const auto decision, LoadDecision(map.ExperienceFolder(id), task));
    if (!decision) pending.tasks.push_back(task);
  }
  return pending;
}

/// Builds pending tasks of a plan; returns what became of all of its tasks.
Result<std::vector<SubmapReport>> BuildPlan(const MapDirectory& map, const PendingTasks& pending,
                                            const Plan& plan, const AddRequest& request, Run& run) {
  if (request.slurm) {
    WAYMARK_TRY(BuildWithSlurm(map, pending, *request.slurm, run));
  } else {
    WAYMARK_TRY(BuildHere(map, pending, request.options.parallelism, run));
  }
  std::vector<SubmapReport> reports;
  for (const std::string& task : plan.tasks) {
    WAYMARK_TRY_ASSIGN(const auto decision,
                       LoadDecision(map.ExperienceFolder(pending.experience), task));
    CHECK(decision.has_value(), "task {} was built", task);
    const bool is_new = std::ranges::find(pending.tasks, task) != pending.tasks.end();
    reports.push_back(ReportOf(task, *decision, !is_new));
  }
  return reports;
}

/// One run, while the map is locked.
class Addition {
 public:
  Addition(const MapDirectory& map, const AddRequest& request, Run& run, std::set<SubmapId> live)
      : map_(map), request_(request), run_(run), live_(std::move(live)), submaps_(live_) {
    report_.is_geo_aligned = map.description().is_geo_aligned;
  }

  /// Ends before an experience whose tasks another job is to wait for.
  Result<void> Add(std::span<const Experience> experiences) {
    for (const Experience& experience : experiences) {
      WAYMARK_TRY_ASSIGN(const Known known,
                         FindKnown(map_, experience, live_, request_.options.parallelism, run_));
      if (known == Known::kLive) {
        report_.already_in_map.push_back(experience.id);
        continue;
      }
      WAYMARK_TRY(AddOne(experience));
      if (awaited_) return {};
    }
    return submaps_ == live_ ? Result<void>() : Release();
  }

  const std::optional<PendingTasks>& awaited() const { return awaited_; }
  AddReport& report() { return report_; }

 private:
  Result<std::pair<ExperienceIndex, Plan>> PlanOne(const Experience& experience) {
    const Parallelism& parallelism = request_.options.parallelism;
    const fs::path folder = map_.ExperienceFolder(experience.id);
    Stopwatch watch;
    IndexTimes times{.features_threads = static_cast<int>(parallelism.ThreadCount())};
    WAYMARK_TRY_ASSIGN(ExperienceIndex index,
                       IndexExperience(experience, TangentPlane(map_.description().origin), folder,
                                       request_.options.features, parallelism, run_));
    times.features_s = watch.Lap();
    WAYMARK_TRY_ASSIGN(Plan plan, PlanExperience(map_, index, submaps_, request_.options));
    times.split_s = watch.Lap();
    WAYMARK_TRY(AddIndexTimes(folder, times));
    return std::pair(std::move(index), std::move(plan));
  }

  /// Takes one experience to decided submaps.
  Result<void> AddOne(const Experience& experience) {
    WAYMARK_TRY_ASSIGN(const auto planned, PlanOne(experience));
    const auto& [index, plan] = planned;
    if (request_.until == AddUntil::kPlan) {
      for (const std::string& task : plan.tasks) {
        report_.submaps.push_back({.task = task, .id = {}, .verdict = "planned"});
      }
      return {};
    }
    WAYMARK_TRY_ASSIGN(PendingTasks pending, FindPending(map_, experience.id, plan));
    if (request_.slurm && request_.slurm->resume && !pending.tasks.empty()) {
      awaited_ = std::move(pending);
      return {};
    }
    WAYMARK_TRY_ASSIGN(std::vector<SubmapReport> built,
                       BuildPlan(map_, pending, plan, request_, run_));
    WAYMARK_TRY_ASSIGN(const auto left_out, ListLeftOut(map_, index, plan));
    report_.left_out.insert(report_.left_out.end(), left_out.begin(), left_out.end());
    return Take(experience.id, std::move(built));
  }

  /// Accepted submaps join the map, and what was built from the experience before in another way
  /// leaves.
  Result<void> Take(const ExperienceId& id, std::vector<SubmapReport> built) {
    std::set<SubmapId> accepted;
    for (SubmapReport& submap : built) {
      if (submap.id) accepted.insert(*submap.id);
      report_.submaps.push_back(std::move(submap));
    }
    (accepted.empty() ? report_.rejected : report_.added).push_back(id);
    if (accepted.empty()) return {};
    WAYMARK_TRY_ASSIGN(const auto built_ever, ListOwnSubmaps(map_.ExperienceFolder(id)));
    for (const SubmapId& old : built_ever) submaps_.erase(old);
    submaps_.insert(accepted.begin(), accepted.end());
    return {};
  }

  Result<void> Release() {
    FusionOptions fusion = request_.options.fusion;
    fusion.parallelism = request_.options.parallelism;
    const auto until =
        request_.until == AddUntil::kCandidate ? ReleaseUntil::kCandidate : ReleaseUntil::kLive;
    WAYMARK_TRY_ASSIGN(NewRelease release,
                       ReleaseSubmaps(map_, submaps_, fusion, request_.created_utc, until, run_));
    report_.epoch = release.epoch;
    report_.unplaced = std::move(release.unplaced);
    report_.overlap_rms_m = release.overlap_rms_m;
    report_.gnss_rms_m = release.gnss_rms_m;
    return {};
  }

  const MapDirectory& map_;
  const AddRequest& request_;
  Run& run_;
  std::set<SubmapId> live_, submaps_;
  std::optional<PendingTasks> awaited_;
  AddReport report_;
};

}  // namespace

Result<AddReport> AddExperiences(const AddRequest& request, const PipelineObserver& observer) {
  WAYMARK_TRY(request.options.Validate());
  if (request.slurm) WAYMARK_TRY(request.slurm->Validate());
  WAYMARK_TRY_ASSIGN(const std::vector<Experience> experiences,
                     LoadAll(request.experience_folders));
  WAYMARK_TRY_ASSIGN(const MapDirectory map, OpenOrCreate(request, experiences));
  WAYMARK_TRY_ASSIGN(std::optional<FileLock> lock, map.LockForWriting());
  WAYMARK_TRY_ASSIGN(std::set<SubmapId> live, LoadLiveSubmaps(map));
  Run run(observer);
  Addition addition(map, request, run, std::move(live));
  WAYMARK_TRY(addition.Add(experiences));
  if (const auto& awaited = addition.awaited()) {
    lock.reset();  // the job that goes on may begin at once
    WAYMARK_TRY_ASSIGN(addition.report().resumes_in, SubmitToSlurm(map, *awaited, *request.slurm));
  }
  return std::move(addition.report());
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

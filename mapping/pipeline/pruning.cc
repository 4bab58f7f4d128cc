// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/pruning.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <string>
#include <utility>

#include "mapping/base/file.h"
#include "mapping/pipeline/internal/membership.h"
#include "mapping/pipeline/internal/planning.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

/// What another process may still be writing is younger.
constexpr std::chrono::hours kStaleAfter(1);

bool IsStale(const fs::path& path) {
  std::error_code failure;
  const auto written = fs::last_write_time(path, failure);
  return !failure && fs::file_time_type::clock::now() - written > kStaleAfter;
}

struct ExperienceFile {
  ExperienceId experience;
  fs::path name;
};

/// What goes, in the order in which it must go, and what that depends on.
struct Doomed {
  std::set<SubmapId> kept;      ///< held by releases that stay
  std::set<SubmapId> released;  ///< held by releases that go, and not by those that stay
  std::set<SubmapId> named;     ///< by decisions that stay
  std::vector<ExperienceId> experiences;
  std::vector<ExperienceFile> files;
  std::vector<SubmapId> submaps;
  std::vector<std::uint64_t> releases;
  std::vector<fs::path> temporaries;
};

Result<void> FindReleases(const MapDirectory& map, std::size_t keep, Doomed& doomed) {
  WAYMARK_TRY_ASSIGN(const auto live, map.LoadCurrentEpoch());
  WAYMARK_TRY_ASSIGN(const auto epochs, map.ListReleaseEpochs());
  for (std::size_t i = 0; i < epochs.size(); ++i) {
    const bool stays = epochs[i] == live || i + keep >= epochs.size();
    if (!stays) doomed.releases.push_back(epochs[i]);
    WAYMARK_TRY_ASSIGN(const Release release, map.LoadRelease(epochs[i]));
    auto& submaps = stays ? doomed.kept : doomed.released;
    for (const ReleasedSubmap& submap : release.submaps) submaps.insert(submap.id);
  }
  for (const SubmapId& id : doomed.kept) doomed.released.erase(id);
  return {};
}

Result<std::vector<std::string>> ListFinished(const fs::path& folder, std::string_view ending) {
  WAYMARK_TRY_ASSIGN(std::vector<std::string> names, ListFolder(folder));
  std::erase_if(names, [&](const std::string& name) {
    return name.starts_with('.') || !name.ends_with(ending);
  });
  return names;
}

/// Features that the index does not name: they were made with other options.
Result<void> FindFeatures(const MapDirectory& map, const ExperienceId& id, Doomed& doomed) {
  const fs::path folder = map.ExperienceFolder(id);
  const auto index = LoadIndex(folder);
  if (!index && index.error().code == ErrorCode::kNotFound) return {};  // being made
  if (!index) return index.error();
  std::set<std::string> named;
  for (const IndexedImage& image : index->images) {
    named.insert(FeaturePath(folder, image.features).filename().string());
  }
  WAYMARK_TRY_ASSIGN(const auto names, ListFinished(folder / "features", ".feat"));
  for (const std::string& name : names) {
    if (!named.contains(name)) doomed.files.push_back({id, fs::path("features") / name});
  }
  return {};
}

/// Decisions whose submap goes, and tasks that are in no plan any more.
Result<void> FindTasks(const MapDirectory& map, const ExperienceId& id,
                       const std::vector<DecidedTask>& decided, Doomed& doomed) {
  const fs::path folder = map.ExperienceFolder(id);
  WAYMARK_TRY_ASSIGN(const std::optional<Plan> plan, LoadPlan(folder));
  const auto is_planned = [&](const std::string& task) {
    return !plan || std::ranges::find(plan->tasks, task) != plan->tasks.end();
  };
  std::set<std::string> known;  // tasks that stay although no plan has them
  for (const auto& [task, decision] : decided) {
    const bool is_kept = decision.submap && doomed.kept.contains(*decision.submap);
    const bool goes = decision.submap && doomed.released.contains(*decision.submap);
    if (is_kept || (is_planned(task) && !goes)) {
      known.insert(task);
      if (decision.submap) doomed.named.insert(*decision.submap);
    } else {
      doomed.files.push_back({id, fs::relative(DecisionPath(folder, task), folder)});
    }
  }
  WAYMARK_TRY_ASSIGN(const auto names, ListFinished(folder / "tasks", ".json"));
  for (const std::string& name : names) {
    const std::string task = name.substr(0, name.find('.'));
    if (name != task + ".json" || is_planned(task) || known.contains(task)) continue;
    doomed.files.push_back({id, fs::path("tasks") / name});
  }
  return {};
}

Result<void> FindExperiences(const MapDirectory& map, Doomed& doomed) {
  WAYMARK_TRY_ASSIGN(const auto ids, map.ListExperiences());
  for (const ExperienceId& id : ids) {
    WAYMARK_TRY_ASSIGN(const auto decided, LoadDecisions(map.ExperienceFolder(id)));
    std::size_t accepted = 0;
    std::size_t going = 0;
    for (const DecidedTask& task : decided) {
      if (!task.decision.submap) continue;
      ++accepted;
      if (doomed.released.contains(*task.decision.submap)) ++going;
    }
    if (going > 0 && going == accepted) {
      doomed.experiences.push_back(id);
      continue;
    }
    WAYMARK_TRY(FindTasks(map, id, decided, doomed));
    WAYMARK_TRY(FindFeatures(map, id, doomed));
  }
  return {};
}

Result<void> FindSubmaps(const MapDirectory& map, Doomed& doomed) {
  WAYMARK_TRY_ASSIGN(const auto stored, map.ListSubmaps());
  for (const SubmapId& id : stored) {
    if (doomed.kept.contains(id) || doomed.named.contains(id)) continue;
    // A builder stores its submap before the decision that names it.
    if (doomed.released.contains(id) || IsStale(map.SubmapPath(id))) doomed.submaps.push_back(id);
  }
  return {};
}

void FindTemporaries(const MapDirectory& map, Doomed& doomed) {
  std::error_code failure;
  for (fs::recursive_directory_iterator entry(map.folder(), failure), end; !failure && entry != end;
       entry.increment(failure)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with('.') && name.ends_with(".tmp") && IsStale(entry->path())) {
      doomed.temporaries.push_back(entry->path());
    }
  }
}

std::uint64_t SizeOf(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    const auto size = fs::file_size(path, ignored);
    return ignored ? 0 : size;
  }
  std::uint64_t total = 0;
  for (const auto& entry : fs::recursive_directory_iterator(path, ignored)) {
    if (entry.is_regular_file(ignored)) total += SizeOf(entry.path());
  }
  return total;
}

PruneReport Describe(const MapDirectory& map, const Doomed& doomed) {
  PruneReport report{.releases = doomed.releases,
                     .submaps = doomed.submaps,
                     .experiences = doomed.experiences,
                     .other_files = doomed.files.size() + doomed.temporaries.size()};
  for (const auto epoch : doomed.releases) report.bytes += SizeOf(map.ReleasePath(epoch));
  for (const SubmapId& id : doomed.submaps) report.bytes += SizeOf(map.SubmapPath(id));
  for (const auto& id : doomed.experiences) report.bytes += SizeOf(map.ExperienceFolder(id));
  for (const ExperienceFile& file : doomed.files) {
    report.bytes += SizeOf(map.ExperienceFolder(file.experience) / file.name);
  }
  for (const fs::path& path : doomed.temporaries) report.bytes += SizeOf(path);
  return report;
}

/// What names a submap goes before it; the releases go last, for they say what still has to go.
Result<void> Delete(const MapDirectory& map, const Doomed& doomed) {
  for (const ExperienceId& id : doomed.experiences) WAYMARK_TRY(map.DeleteExperience(id));
  for (const ExperienceFile& file : doomed.files) {
    WAYMARK_TRY(map.DeleteExperienceFile(file.experience, file.name));
  }
  for (const SubmapId& id : doomed.submaps) WAYMARK_TRY(map.DeleteSubmap(id));
  std::error_code ignored;  // another process may have renamed or deleted it
  for (const fs::path& path : doomed.temporaries) fs::remove(path, ignored);
  for (const std::uint64_t epoch : doomed.releases) WAYMARK_TRY(map.DeleteRelease(epoch));
  return {};
}

}  // namespace

Result<PruneReport> PruneMap(const PruneRequest& request) {
  if (request.keep < 1) {
    return MakeError(ErrorCode::kInvalidArgument, "expected at least 1 release to keep, found {}",
                     request.keep);
  }
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(request.map_folder));
  WAYMARK_TRY_ASSIGN(const FileLock lock, map.LockForWriting());
  Doomed doomed;
  WAYMARK_TRY(FindReleases(map, request.keep, doomed));
  WAYMARK_TRY(FindExperiences(map, doomed));
  WAYMARK_TRY(FindSubmaps(map, doomed));
  FindTemporaries(map, doomed);
  PruneReport report = Describe(map, doomed);
  if (request.is_rehearsal) return report;
  WAYMARK_TRY(map.FinishDeletions());
  WAYMARK_TRY(Delete(map, doomed));
  return report;
}

}  // namespace waymark::mapping

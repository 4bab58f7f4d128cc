// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "mapping/pipeline/internal/index_times.h"
#include "mapping/pipeline/internal/left_out.h"
#include "mapping/pipeline/internal/membership.h"
#include "mapping/pipeline/internal/planning.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

using Place = std::pair<std::int64_t, std::int64_t>;

/// Which experiences saw a place, and whether the live release holds it.
struct Passes {
  std::set<ExperienceId> experiences;
  bool is_live = false;
};

SubmapRecord MakeRecord(const std::string& task, const std::optional<Decision>& decision,
                        const std::set<SubmapId>& live) {
  SubmapRecord record{.task = task};
  if (!decision) return record;
  record.id = decision->submap;
  record.state = !record.id                  ? SubmapState::kRejected
                 : live.contains(*record.id) ? SubmapState::kLive
                                             : SubmapState::kNotLive;
  record.verdict = decision->verdict;
  record.images = decision->images;
  record.landmarks = decision->landmarks;
  record.left_out = decision->left_out.size();
  record.figures = decision->figures;
  record.times = decision->times;
  return record;
}

/// Adds the names of the task's own images that its submap holds.
Result<void> AddHeldImages(const fs::path& folder, const std::string& name,
                           const Decision& decision, std::set<std::string>& held) {
  WAYMARK_TRY_ASSIGN(const SubmapTask task, LoadTask(folder, name));
  std::set<std::string> left_out;
  for (const LeftOutImage& image : decision.left_out) left_out.insert(image.name);
  for (const TaskImage& image : task.images) {
    if (!image.is_borrowed && !left_out.contains(image.name)) held.insert(image.name);
  }
  return {};
}

Place PlaceOf(const Point<Map>& position, double place_m) {
  return {std::llround(std::floor(position.coordinates().x() / place_m)),
          std::llround(std::floor(position.coordinates().y() / place_m))};
}

/// Takes in one experience; nothing when it has no plan yet.
Result<void> AddExperience(const MapDirectory& map, const ExperienceId& id,
                           const std::set<SubmapId>& live, std::map<Place, Passes>& places,
                           MapReport& report) {
  const fs::path folder = map.ExperienceFolder(id);
  WAYMARK_TRY_ASSIGN(const ExperienceIndex index, LoadIndex(folder));
  WAYMARK_TRY_ASSIGN(const std::optional<Plan> plan, LoadPlan(folder));
  if (!plan) return {};
  ExperienceRecord record{.id = id, .images = index.images.size()};
  WAYMARK_TRY_ASSIGN(record.times, LoadIndexTimes(folder));
  WAYMARK_TRY_ASSIGN(record.left_out, ListLeftOut(map, index, *plan));
  std::set<std::string> held;
  for (const std::string& task : plan->tasks) {
    WAYMARK_TRY_ASSIGN(const std::optional<Decision> decision, LoadDecision(folder, task));
    record.submaps.push_back(MakeRecord(task, decision, live));
    if (!decision) continue;
    ++report.attempted;
    if (decision->submap) ++report.accepted;
    if (record.submaps.back().state != SubmapState::kLive) continue;
    WAYMARK_TRY(AddHeldImages(folder, task, *decision, held));
  }
  if (map.description().is_geo_aligned) {
    const TangentPlane plane(map.description().origin);
    for (const IndexedImage& image : index.images) {
      if (!image.gnss) continue;
      Passes& passes = places[PlaceOf(plane.ToMap(*image.gnss), report.place_m)];
      passes.experiences.insert(id);
      passes.is_live = passes.is_live || held.contains(image.name);
    }
  }
  report.experiences.push_back(std::move(record));
  return {};
}

std::vector<YieldRow> CountYield(const std::map<Place, Passes>& places) {
  std::size_t most = 0;
  for (const auto& [place, passes] : places) most = std::max(most, passes.experiences.size());
  std::vector<YieldRow> rows;
  for (std::size_t least = 1; least <= most; ++least) {
    YieldRow row{.passes = static_cast<int>(least)};
    for (const auto& [place, passes] : places) {
      if (passes.experiences.size() < least) continue;
      ++row.attempted;
      if (passes.is_live) ++row.reconstructed;
    }
    rows.push_back(row);
  }
  return rows;
}

std::vector<StageRow> SumTimes(const MapReport& report, const std::optional<Release>& live) {
  StageRow split{"data splitting", 1, 0, "experience", 0};
  StageRow features{"feature detection", 1, 0, "experience", 0};
  StageRow matching{"feature matching", 1, 0, "submap", 0};
  StageRow reconstruction{"structure from motion", 1, 0, "submap", 0};
  StageRow verification{"verification", 1, 0, "submap", 0};
  StageRow fusion{"fusion of the live release", 1, 0, "release", 0};
  const auto add = [](StageRow& row, double seconds, int threads = 1) {
    ++row.units;
    row.total_s += seconds;
    row.threads = std::max(row.threads, threads);
  };
  for (const ExperienceRecord& experience : report.experiences) {
    if (experience.times.features_threads > 0) {  // otherwise nobody took the time
      add(split, experience.times.split_s);
      add(features, experience.times.features_s, experience.times.features_threads);
    }
    for (const SubmapRecord& submap : experience.submaps) {
      if (submap.times.matching_threads == 0) continue;
      add(matching, submap.times.matching_s, submap.times.matching_threads);
      add(reconstruction, submap.times.reconstruction_s);
      add(verification, submap.times.verification_s);
    }
  }
  if (live && live->fusion_s) add(fusion, *live->fusion_s);
  return {split, features, matching, reconstruction, verification, fusion};
}

}  // namespace

std::string_view SubmapStateName(SubmapState state) {
  switch (state) {
    case SubmapState::kLive:
      return "live";
    case SubmapState::kNotLive:
      return "not live";
    case SubmapState::kRejected:
      return "rejected";
    case SubmapState::kUnbuilt:
      return "not built";
  }
  return "unknown";
}

Result<MapReport> ReportMap(const fs::path& map_folder) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(map_folder));
  WAYMARK_TRY_ASSIGN(const auto epoch, map.LoadCurrentEpoch());
  std::optional<Release> release;
  std::set<SubmapId> live;
  if (epoch) {
    WAYMARK_TRY_ASSIGN(release, map.LoadRelease(*epoch));
    for (const ReleasedSubmap& submap : release->submaps) live.insert(submap.id);
  }
  MapReport report;
  std::map<Place, Passes> places;
  WAYMARK_TRY_ASSIGN(const std::vector<ExperienceId> ids, ListPlannedExperiences(map));
  for (const ExperienceId& id : ids) {
    WAYMARK_TRY(AddExperience(map, id, live, places, report));
  }
  report.yield = CountYield(places);
  report.stages = SumTimes(report, release);
  return report;
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/removing.h"

#include <algorithm>
#include <set>
#include <utility>

#include "mapping/experience/names.h"
#include "mapping/pipeline/internal/area.h"
#include "mapping/pipeline/internal/membership.h"
#include "mapping/pipeline/internal/releasing.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

Result<void> CheckRequest(const RemoveRequest& request) {
  WAYMARK_TRY(request.fusion.Validate());
  if (request.submaps.empty() && request.experiences.empty() && request.areas.empty()) {
    return MakeError(ErrorCode::kInvalidArgument, "nothing to remove was named");
  }
  for (const SubmapId& id : request.submaps) {
    if (IsSubmapIdText(id.text())) continue;
    return MakeError(ErrorCode::kInvalidArgument,
                     "submap {}: expected 32 hexadecimal digits, as `waymark-map info` prints them",
                     id.text());
  }
  for (const ExperienceId& id : request.experiences) {
    if (IsExperienceIdText(id.text())) continue;
    return MakeError(ErrorCode::kInvalidArgument, "experience {}: no name of an experience",
                     id.text());
  }
  return {};
}

/// Submaps that the map once held are known even when they are not live any more.
Result<void> FindNamedSubmaps(const MapDirectory& map, const RemoveRequest& request,
                              const std::set<SubmapId>& released, std::set<SubmapId>& leaving) {
  for (const SubmapId& id : request.submaps) {
    std::error_code ignored;
    if (!released.contains(id) && !fs::exists(map.SubmapPath(id), ignored)) {
      return MakeError(ErrorCode::kNotFound, "{}: no submap {}", map.folder().string(), id.text());
    }
    leaving.insert(id);
  }
  return {};
}

Result<void> FindSubmapsOfExperiences(const MapDirectory& map, const RemoveRequest& request,
                                      std::set<SubmapId>& leaving) {
  for (const ExperienceId& id : request.experiences) {
    const fs::path folder = map.ExperienceFolder(id);
    std::error_code ignored;
    if (!fs::exists(folder, ignored)) {
      return MakeError(ErrorCode::kNotFound, "{}: no experience {}", map.folder().string(),
                       id.text());
    }
    WAYMARK_TRY_ASSIGN(const std::set<SubmapId> own, ListOwnSubmaps(folder));
    leaving.insert(own.begin(), own.end());
  }
  return {};
}

Result<void> FindSubmapsInAreas(const MapDirectory& map, const RemoveRequest& request,
                                const Release& live, std::set<SubmapId>& leaving) {
  if (request.areas.empty()) return {};
  if (!map.description().is_geo_aligned) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "{}: was made without GNSS, so no latitude and longitude is in it",
                     map.folder().string());
  }
  const TangentPlane plane(map.description().origin);
  for (const Area& area : request.areas) {
    WAYMARK_TRY_ASSIGN(const PlaneArea on_plane, PlaneArea::Create(area, plane));
    for (const ReleasedSubmap& submap : live.submaps) {
      if (on_plane.Contains(submap.centre)) leaving.insert(submap.id);
    }
  }
  return {};
}

/// Makes the release of what stays.
Result<void> MakeRelease(const MapDirectory& map, const std::set<SubmapId>& staying,
                         const RemoveRequest& request, const PipelineObserver& observer,
                         RemoveReport& report) {
  const auto until = request.is_candidate ? ReleaseUntil::kCandidate : ReleaseUntil::kLive;
  if (!request.places_anew) {
    WAYMARK_TRY_ASSIGN(report.epoch, ReleaseInPlace(map, staying, request.created_utc, until));
    return {};
  }
  Run run(observer);
  WAYMARK_TRY_ASSIGN(NewRelease release,
                     ReleaseSubmaps(map, staying, request.fusion, request.created_utc, until, run));
  report.epoch = release.epoch;
  report.unplaced = std::move(release.unplaced);
  return {};
}

/// Deletes the experiences that no stored release needs, with submaps that were never released.
Result<void> DeleteUnneeded(const MapDirectory& map, const RemoveRequest& request,
                            const std::set<SubmapId>& released, RemoveReport& report) {
  for (const ExperienceId& id : request.experiences) {
    WAYMARK_TRY_ASSIGN(const std::set<SubmapId> own, ListOwnSubmaps(map.ExperienceFolder(id)));
    const auto is_released = [&](const SubmapId& submap) { return released.contains(submap); };
    if (std::ranges::any_of(own, is_released)) {
      report.still_needed.push_back(id);
      continue;
    }
    WAYMARK_TRY(map.DeleteExperience(id));
    for (const SubmapId& submap : own) WAYMARK_TRY(map.DeleteSubmap(submap));
    report.deleted.push_back(id);
  }
  return {};
}

}  // namespace

Result<RemoveReport> RemoveFromMap(const RemoveRequest& request, const PipelineObserver& observer) {
  WAYMARK_TRY(CheckRequest(request));
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(request.map_folder));
  WAYMARK_TRY_ASSIGN(const FileLock lock, map.LockForWriting());
  WAYMARK_TRY(map.FinishDeletions());
  WAYMARK_TRY_ASSIGN(const auto epoch, map.LoadCurrentEpoch());
  Release live;
  if (epoch) {
    WAYMARK_TRY_ASSIGN(live, map.LoadRelease(*epoch));
  }
  WAYMARK_TRY_ASSIGN(const std::set<SubmapId> released, LoadReleasedSubmaps(map));

  std::set<SubmapId> leaving;
  WAYMARK_TRY(FindNamedSubmaps(map, request, released, leaving));
  WAYMARK_TRY(FindSubmapsOfExperiences(map, request, leaving));
  WAYMARK_TRY(FindSubmapsInAreas(map, request, live, leaving));
  RemoveReport report;
  std::set<SubmapId> staying;
  for (const ReleasedSubmap& submap : live.submaps) {
    if (leaving.contains(submap.id)) {
      report.removed.push_back(submap.id);
    } else {
      staying.insert(submap.id);
    }
  }
  if (!report.removed.empty() && staying.empty()) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "{}: nothing would be left of the {} submaps of epoch {}; add what replaces "
                     "them first, or delete the map's folder",
                     map.folder().string(), live.submaps.size(), live.epoch);
  }
  if (!report.removed.empty()) {
    WAYMARK_TRY(MakeRelease(map, staying, request, observer, report));
  }
  WAYMARK_TRY(DeleteUnneeded(map, request, released, report));
  return report;
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mapping/fusion/fusion.h"
#include "mapping/geometry/geodesy.h"
#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

/// A simple polygon; its last corner joins the first. Heights mean nothing.
using Area = std::vector<GeoPoint>;

/// What to take out of a map; all of it leaves in one release.
struct RemoveRequest {
  std::filesystem::path map_folder = {};
  std::vector<SubmapId> submaps = {};
  std::vector<ExperienceId> experiences = {};  ///< with all that was built from them
  std::vector<Area> areas = {};                ///< submaps whose centre lies within
  bool places_anew = false;      ///< fuse what stays, rather than leave it where it is
  FusionOptions fusion = {};     ///< for that
  bool is_candidate = false;     ///< store the release, but leave the live one live
  std::string created_utc = {};  ///< ISO 8601, of the release
};

struct RemoveReport {
  std::vector<SubmapId> removed;           ///< of the live release, by id
  std::vector<ExperienceId> deleted;       ///< folders that no stored release needs
  std::vector<ExperienceId> still_needed;  ///< named, but a stored release holds their submaps
  std::vector<SubmapId> unplaced;          ///< fused, and only the removed ones held them
  std::optional<std::uint64_t> epoch;      ///< absent: the live release holds none of it
};

/// Makes the next release without some submaps. What stays is exactly where it was, with the
/// residuals it had, until the next fusion; or is fused at once, so that the map does not remember
/// what it held. No submap is built or changed, and images that others borrowed stay with them. The
/// folder of a named experience is deleted when no stored release holds a submap of it; otherwise
/// PruneMap deletes it with the releases that do. Adding the experience again brings all of it
/// back. Naming what is not in the live release any more is no error, so a run that was killed is
/// simply run again. Errors: InvalidArgument (nothing named, an id that is none, an area of fewer
/// than 3 corners or without inside, an area of a map without GNSS, or nothing would be left: a
/// served map never goes blank); NotFound (no such map, submap or experience, no live release);
/// Conflict (another writer); those of fusion and storage.
Result<RemoveReport> RemoveFromMap(const RemoveRequest& request,
                                   const PipelineObserver& observer = {});

}  // namespace waymark::mapping

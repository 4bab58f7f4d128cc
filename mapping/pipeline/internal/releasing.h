// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "mapping/pipeline/internal/run.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {

/// How far to take a release: a candidate is stored, but not live.
enum class ReleaseUntil { kCandidate, kLive };

/// A release that is stored, with what fusion says about the whole.
struct NewRelease {
  std::optional<std::uint64_t> epoch;  ///< absent: the live release holds the same submaps
  std::vector<SubmapId> unplaced;
  double overlap_rms_m = 0;
  double gnss_rms_m = 0;
};

/// Fuses submaps and makes the result the next epoch, unless those that can be placed are live
/// already. The newest release is taken when it is the same one from the same parent: an earlier
/// run that was killed, or that left it as a candidate, made it. The caller holds the map's lock.
/// Errors: those of FuseSubmaps, SubmapView and storage; NotFound when no submap can be placed.
Result<NewRelease> ReleaseSubmaps(const MapDirectory& map, const std::set<SubmapId>& submaps,
                                  const FusionOptions& options, std::string_view created_utc,
                                  ReleaseUntil until, Run& run);

/// Makes the next release of some of the live one's submaps, each exactly where it is, with the
/// residuals that are known of it; otherwise as ReleaseSubmaps. `submaps` is not empty.
Result<std::uint64_t> ReleaseInPlace(const MapDirectory& map, const std::set<SubmapId>& submaps,
                                     std::string_view created_utc, ReleaseUntil until);

/// The east-north-up frame at a place, in the map frame.
Sim3 MapFromEnu(const TangentPlane& map, const GeoPoint& origin);

}  // namespace waymark::mapping

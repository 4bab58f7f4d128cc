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

/// A release that is stored and live, with what fusion says about the whole.
struct NewRelease {
  std::optional<std::uint64_t> epoch;  ///< absent: the live release holds the same submaps
  std::vector<SubmapId> unplaced;
  double overlap_rms_m = 0;
  double gnss_rms_m = 0;
};

/// Fuses submaps and deploys the result as the next epoch, unless those that can be placed are live
/// already. The caller holds the map's lock.
/// Errors: those of FuseSubmaps, SubmapView and storage; NotFound when no submap can be placed.
Result<NewRelease> ReleaseSubmaps(const MapDirectory& map, const std::set<SubmapId>& submaps,
                                  const FusionOptions& options, std::string_view created_utc,
                                  Run& run);

/// The east-north-up frame at a place, in the map frame.
Sim3 MapFromEnu(const TangentPlane& map, const GeoPoint& origin);

}  // namespace waymark::mapping

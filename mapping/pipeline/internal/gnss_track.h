// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "mapping/experience/experience.h"
#include "mapping/geometry/frames.h"

namespace waymark::mapping {

struct GnssTrackOptions {
  double acceleration_mps2 = 2;    ///< how a vehicle may stray from the line between two fixes
  double max_sigma_m = 50;         ///< less certain positions are none
  double max_extrapolation_s = 1;  ///< before the first and after the last fix
};

/// A fix in the map frame.
struct GnssFix {
  SensorTime time;
  Eigen::Vector3d position_in_map;
  double sigma_m;
};

/// A position with the standard deviation of one axis.
struct GnssPosition {
  Point<Map> position;
  double sigma_m;
};

/// GNSS fixes of one receiver as a function of time. Immutable.
class GnssTrack {
 public:
  GnssTrack(std::span<const GnssRecord> records, const TangentPlane& map,
            const GnssTrackOptions& options);

  /// Where the antenna was: on the line between the two fixes around the time; the standard
  /// deviation grows with the distance in time to both, by what the vehicle's acceleration allows.
  std::optional<GnssPosition> FindPosition(SensorTime time) const;

  std::span<const GnssFix> fixes() const { return fixes_; }

 private:
  std::vector<GnssFix> fixes_;
  GnssTrackOptions options_;
};

}  // namespace waymark::mapping

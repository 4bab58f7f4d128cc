// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "mapping/experience/experience.h"
#include "mapping/pipeline/internal/gnss_track.h"

namespace waymark::mapping {

struct LevellingOptions {
  double window_s = 20;              ///< stretch of the drive that is levelled at once
  double min_window_s = 3;           ///< shorter ones say too little
  int min_fixes = 4;                 ///< GNSS fixes in a window
  double max_tilt_sigma_rad = 0.05;  ///< less certain directions are none
  double max_residual_sigmas = 3;    ///< rms against GNSS; more means that something is broken
};

/// The direction up in an IMU's axes while its vehicle accelerates and turns. What an accelerometer
/// feels in a bend leans by 25 degrees, so a mean over time is no vertical; but integrated twice,
/// in the frame that the gyroscope carries, it must lead from GNSS fix to GNSS fix, and only one
/// attitude makes it do so (see strapdown_fit.h). Solved for windows that overlap by half, each
/// with its own biases; where two tell, the one that is more certain then. Immutable, thread-safe.
class Levelling {
 public:
  /// Records of one accelerometer, of one gyroscope whose values are turned into the same axes,
  /// and of the receiver.
  Levelling(std::span<const ImuRecord> accelerometer, std::span<const ImuRecord> gyroscope,
            std::span<const GnssFix> fixes, const LevellingOptions& options);

  /// Unit vector; nullopt where no window is certain.
  std::optional<Eigen::Vector3d> FindUp(SensorTime time) const;

 private:
  struct Sample {
    SensorTime time;
    Eigen::Vector3d up_in_sensor;
    double sigma_rad;
  };
  struct Window {
    SensorTime begin;
    SensorTime end;
    std::vector<Sample> samples;
  };

  static std::optional<Window> Level(std::span<const ImuRecord> accelerometer,
                                     std::span<const ImuRecord> gyroscope,
                                     std::span<const GnssFix> fixes,
                                     const LevellingOptions& options);

  double max_tilt_sigma_rad_ = 0;
  std::vector<Window> windows_;
};

}  // namespace waymark::mapping

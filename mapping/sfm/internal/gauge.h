// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/sfm/incremental.h"
#include "mapping/sfm/internal/model.h"

namespace waymark::mapping::internal {

/// What fixes the frame of a model.
enum class Gauge {
  kFree,        ///< nothing: the first camera
  kUpright,     ///< gravity: z is up, the rest is arbitrary
  kGeographic,  ///< GNSS: the submap frame
};

/// The frame of a growing model.
struct GaugeState {
  Gauge gauge = Gauge::kFree;
  /// Positions lie on a line and no accelerometer says where up is: horizontal camera x axes must.
  bool needs_level = false;
  /// Of one accelerometer direction, after asking whether they agree with each other.
  double gravity_sigma_rad = 0.02;
  /// The rig's links agree with each other and, where there is GNSS, with it.
  bool trusts_rig = false;
};

/// Moves the model into the best frame that its images now allow; never falls back to a worse one.
GaugeState UpdateGauge(Model& model, const GaugeState& before, const SfmOptions& options);

/// Gives a model without geography its conventional frame: centred, z up as far as known, and,
/// where no rig tells the scale, the median distance between successive images 1 m.
void NormaliseGauge(Model& model, const GaugeState& state);

}  // namespace waymark::mapping::internal

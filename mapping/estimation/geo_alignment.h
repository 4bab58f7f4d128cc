// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/estimation/geo_sample.h"
#include "mapping/geometry/sim3.h"

namespace waymark::mapping {

struct GeoAlignmentOptions {
  double gravity_sigma_rad = 0.02;
  double level_sigma_rad = 0.2;   ///< of "camera x axes are horizontal", used without gravity
  double max_error_sigmas = 3;    ///< of a position that still counts
  double max_scale_error = 0.25;  ///< expected relative error above which positions say nothing
  std::uint64_t seed = 1;
};

struct GeoAlignment {
  Sim3 enu_from_model;
  std::vector<std::uint32_t> inliers;  ///< samples whose position fits, ascending
  bool is_straight = false;  ///< positions lie on a line: roll about it came from up directions
};

/// Aligns a reconstruction to GNSS and gravity by a robust similarity. nullopt: fewer than three
/// positions fit, or they are too close together for their noise to give a scale.
std::optional<GeoAlignment> EstimateGeoAlignment(std::span<const GeoSample> samples,
                                                 const GeoAlignmentOptions& options);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/geometry/rigid3.h"
#include "mapping/geometry/sim3.h"
#include "mapping/io/tum_trajectory.h"

namespace waymark::evaluation {

using Trajectory = mapping::NamedPoses;

/// Errors: NotFound, Corrupt with file and line.
Result<Trajectory> LoadTumTrajectory(const std::filesystem::path& path);
using mapping::ParseTumTrajectory;

/// The camera-position columns of waymark-localise's table; refused images are left out.
Result<Trajectory> LoadPoseTable(const std::filesystem::path& path);

/// The similarity `truth_from_estimate` that minimises, over the common images,
///   sum |c_truth - T c_estimate|^2 + lambda^2 |R_truth - R R_estimate|^2,
/// where lambda is 1 % of the spread of the true positions. Positions decide wherever they can; the
/// second term settles the turn about the path when that is nearly straight, which positions alone
/// leave free. Errors: InvalidArgument for fewer than 2 common images or positions all in one
/// place. Source: Umeyama, PAMI 1991, with the rotations as further correspondences.
Result<Sim3> EstimateAlignment(const Trajectory& estimate, const Trajectory& truth);

/// Errors of the common images after (or without) an alignment.
struct TrajectoryErrors {
  std::size_t common = 0;
  double mean_m = 0;
  double median_m = 0;
  double rmse_m = 0;
  double max_m = 0;
  double median_rotation_rad = 0;
  double path_m = 0;  ///< length of the true path through the common images, in order of names
};

TrajectoryErrors ComputeErrors(const Trajectory& estimate, const Trajectory& truth,
                               const Sim3& truth_from_estimate);

}  // namespace waymark::evaluation

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <vector>

#include "mapping/base/parallel.h"
#include "mapping/base/result.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// Intrinsics in an adjustment. The principal point and tangential distortion never move: a lens
/// off centre looks much like a camera that is turned.
struct BundleCamera {
  CameraModel model;
  bool hold = true;
  CameraModel initial;              ///< the priors below pull towards it
  double focal_sigma_share = 0.05;  ///< of the initial focal length
  double aspect_sigma = 0.001;      ///< of the ratio of two focal lengths: pixels are made square
  double lens_sigma = 0.1;          ///< of each radial distortion coefficient
};

struct BundlePose {
  Rigid3 world_from_camera;
  std::uint32_t camera = 0;
  bool hold = false;
  std::optional<Eigen::Vector3d> position_prior;  ///< of the camera centre, in the world
  double position_sigma_m = 1;
  std::optional<Eigen::Vector3d> up_in_camera;  ///< unit length; "up" is the world's z
  bool is_level = false;                        ///< weakly assume a horizontal camera x axis
};

struct BundleObservation {
  std::uint32_t pose;
  std::uint32_t point;
  Eigen::Vector2d pixel_px;
};

/// Another camera of the same rig, between two of its poses, seen from `pose`.
struct BundleRigLink {
  std::uint32_t pose;
  std::uint32_t before;
  std::uint32_t after;
  double share;  ///< of the way from `before` to `after`
  Eigen::Vector3d offset_in_camera;
  double sigma_m;
};

/// Everything that an adjustment reads and changes.
struct BundleProblem {
  std::vector<BundleCamera> cameras;
  std::vector<BundlePose> poses;
  std::vector<Eigen::Vector3d> points_in_world;
  std::vector<BundleObservation> observations;
  std::vector<BundleRigLink> rig_links;

  /// Errors: InvalidArgument for an index that names nothing.
  Result<void> Validate() const;
};

enum class BundleSolver {
  kOwn,    ///< the same bits on any number of threads
  kCeres,  ///< the reference that the other is held against; slower, and its bits vary with threads
};

enum class ObservationLoss { kSquared, kHuber, kCauchy };

struct BundleOptions {
  double pixel_sigma_px = 1;  ///< of a feature's position: balances pixels against priors
  ObservationLoss loss = ObservationLoss::kCauchy;
  double loss_scale = 2;      ///< in sigmas: where the loss departs from the square
  double position_scale = 2;  ///< the same for position priors and rig links (Cauchy)
  double gravity_sigma_rad = 0.02;
  double level_sigma_rad = 0.2;
  BundleSolver solver = BundleSolver::kOwn;
  int max_iterations = 50;
  double relative_tolerance = 1e-6;  ///< of the cost, to stop
  Parallelism parallelism;
};

struct BundleSummary {
  double initial_cost = 0;
  double final_cost = 0;
  int iterations = 0;
  bool converged = false;
};

/// Minimises cost (1): robust reprojection error plus robust position priors and rig links, with
/// gravity and intrinsics priors. Without any prior or held pose the gauge is free; damping keeps
/// it in place. Errors: InvalidArgument for indices out of range; Unavailable when the solver
/// fails. Source: Platinsky et al. 2020, eq. (1).
Result<BundleSummary> AdjustBundle(BundleProblem& problem, const BundleOptions& options);

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "mapping/estimation/bundle_adjustment.h"

namespace waymark::mapping {

Result<void> BundleProblem::Validate() const {
  for (const BundlePose& pose : poses) {
    if (pose.camera >= cameras.size()) {
      return MakeError(ErrorCode::kInvalidArgument, "bundle: pose with camera {} of {}",
                       pose.camera, cameras.size());
    }
  }
  for (const BundleObservation& observation : observations) {
    if (observation.pose >= poses.size() || observation.point >= points_in_world.size()) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "bundle: observation of point {} of {} by pose {} of {}", observation.point,
                       points_in_world.size(), observation.pose, poses.size());
    }
  }
  for (const BundleRigLink& link : rig_links) {
    if (std::max({link.pose, link.before, link.after}) >= poses.size()) {
      return MakeError(ErrorCode::kInvalidArgument, "bundle: rig link ({}, {}, {}) of {} poses",
                       link.pose, link.before, link.after, poses.size());
    }
  }
  return {};
}

}  // namespace waymark::mapping

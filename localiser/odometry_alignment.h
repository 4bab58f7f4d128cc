// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "mapping/base/id.h"
#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/geometry/frames.h"

namespace waymark::localiser {

/// One localised keyframe as the phone keeps it.
struct MapFix {
  DeviceTime time;                         ///< when the image was taken
  Transform<Vo, Device> vo_from_device;    ///< odometry at that instant
  Transform<Map, Device> map_from_device;  ///< the answer
  Eigen::Matrix<double, 6, 6> covariance;  ///< of Perturb's delta in the map frame
  SubmapId submap;                         ///< for carrying the fix to later releases
  Transform<Submap, Device> submap_from_device;
};

struct AlignmentOptions {
  std::chrono::duration<double> half_life{20};  ///< a fix of this age counts half: cost (3)'s tau
  double huber_m = 0.5;                         ///< residuals above count linearly
  double max_disagreement_m = 2;  ///< a fix farther from the consensus is no evidence for `fixed`
  std::size_t max_fixes = 32;     ///< memory and time are O(1)
  std::chrono::duration<double> stale_after{30};

  Result<void> Validate() const;
};

enum class AlignmentState : std::uint8_t { kNever, kCoarse, kFixed, kStale };

/// map_from_vo with its evidence.
struct Alignment {
  AlignmentState state = AlignmentState::kNever;
  std::optional<Transform<Map, Vo>> map_from_vo;  ///< absent while kNever
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
  int supporting_fixes = 0;
};

/// Joins a phone's odometry to the map from its recent fixes: cost (3), 4 degrees of freedom (both
/// frames know gravity), Huber loss, exponential decay by age. Thread-compatible, no clock of its
/// own. Source: Platinsky et al. 2020, eq. (3)-(4).
class OdometryAlignment {
 public:
  explicit OdometryAlignment(const AlignmentOptions& options);

  void AddFix(const MapFix& fix);
  /// The odometry lost its frame (app paused, tracking reset): earlier fixes mean nothing now.
  void ResetOdometry();
  /// The best alignment as of `now`.
  Alignment Estimate(DeviceTime now) const;

  const std::deque<MapFix>& fixes() const { return fixes_; }

 private:
  AlignmentOptions options_;
  std::deque<MapFix> fixes_;  // oldest first
};

}  // namespace waymark::localiser

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "mapping/base/id.h"
#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/geometry/angle.h"
#include "mapping/geometry/frames.h"

namespace waymark::localiser {

/// One localised keyframe as the phone keeps it.
struct MapFix {
  DeviceTime time;                         ///< when the image was taken
  Transform<Vo, Device> vo_from_device;    ///< odometry at that instant
  Transform<Map, Device> map_from_device;  ///< the answer
  Eigen::Matrix<double, 6, 6> covariance;  ///< of Perturb's delta in the map frame
  SubmapId submap;                         ///< for carrying the fix to later releases
  /// The camera that took it, apart from the device: a submap has a scale, and the way from camera
  /// to device has none.
  Transform<Submap, Camera> submap_from_camera;
  Transform<Camera, Device> camera_from_device;
};

/// What the alignment may turn. Odometry and map both know gravity, so two angles are settled.
enum class AlignmentFreedom : std::uint8_t { kYawAndTranslation, kFull };

struct AlignmentOptions {
  std::chrono::duration<double> half_life{20};  ///< a fix of this age counts half: cost (3)'s tau
  /// Of the way that odometry is off: a fix counts the less the farther the phone has come since.
  double drift_share = 0.03;
  double huber_m = 0.5;           ///< residuals above count linearly
  double max_disagreement_m = 2;  ///< a fix farther from the consensus is left out of it
  std::size_t max_fixes = 32;     ///< memory and time are O(1); the oldest goes first, [1, 1000]
  std::chrono::duration<double> stale_after{30};  ///< without a supporting fix for so long
  int min_supporting_fixes = 3;                   ///< agreeing fixes that make `fixed`
  /// Map and drift error, added to every fix's own; once more to the answer's: the map's is in all
  /// fixes alike.
  double sigma_floor_m = 0.05;
  Angle sigma_floor_angle = Angle::Degrees(1);  ///< added to the sigma of every fix's rotation
  Angle max_disagreement_angle = Angle::Degrees(20);  ///< turned or tilted farther: left out
  AlignmentFreedom freedom = AlignmentFreedom::kYawAndTranslation;

  Result<void> Validate() const;
};

enum class AlignmentState : std::uint8_t {
  kNever,   ///< no fix since the odometry's start
  kCoarse,  ///< a best guess: too few fixes, or too many that contradict it
  kFixed,   ///< enough fixes agree, and they are the majority
  kStale,   ///< was agreed upon, but long ago: the odometry has drifted since
};

/// map_from_vo with its evidence.
struct Alignment {
  AlignmentState state = AlignmentState::kNever;
  std::optional<Transform<Map, Vo>> map_from_vo;  ///< absent while kNever
  /// Of Perturb's delta of map_from_vo; grows with the age of the fixes. With four freedoms the
  /// tilt that fixes see and the alignment does not follow is part of it.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
  int supporting_fixes = 0;     ///< that agree with it
  int contradicting_fixes = 0;  ///< kept, but left out
};

/// Joins a phone's odometry to the map from its recent fixes: cost (3), 4 degrees of freedom (both
/// frames know gravity), Huber loss, decay by age and by the way since, after a vote among the
/// fixes that leaves gross errors out. Thread-compatible, no clock of its own. Source: Platinsky et
/// al. 2020, eq. (3)-(4).
class OdometryAlignment {
 public:
  explicit OdometryAlignment(const AlignmentOptions& options);

  /// Answers may arrive out of order. A second fix of the same instant replaces the first. A fix
  /// that is older than the newest by more than `stale_after` means that the phone's clock was set
  /// back: everything before is forgotten. Fixes with numbers that are not finite are ignored.
  void AddFix(const MapFix& fix);
  /// The odometry lost its frame (app paused, tracking reset): earlier fixes mean nothing now.
  void ResetOdometry();
  /// The phone's clock was set forward by so much: the fixes are as old as before.
  void ShiftTime(std::chrono::nanoseconds by);
  /// Another release of the map is live: each fix goes where its submap does, those in submaps that
  /// are not told are forgotten. Returns how the newest fix that stays moved; nullopt: none stays.
  std::optional<Transform<Map, Map>> CarryTo(
      const std::map<SubmapId, Similarity<Map, Submap>>& placements);
  /// The best alignment as of `now`. Deterministic; 0.2 ms with 32 fixes, so call it after a
  /// new fix rather than for every frame.
  Alignment Estimate(DeviceTime now) const;

  const std::deque<MapFix>& fixes() const { return fixes_; }

 private:
  AlignmentOptions options_;
  std::deque<MapFix> fixes_;  // oldest first
};

}  // namespace waymark::localiser

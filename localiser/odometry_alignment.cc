// SPDX-License-Identifier: Apache-2.0
#include "localiser/odometry_alignment.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <vector>

#include "localiser/internal/alignment_consensus.h"
#include "mapping/base/check.h"

namespace waymark::localiser {
namespace {

constexpr double kMaxHalvings = 30;  // a weight never vanishes, or sums of old ones would

// In floating point: instants of a hostile clock may be farther apart than a duration can say.
double SecondsBetween(DeviceTime earlier, DeviceTime later) {
  return (static_cast<double>(ToNanoseconds(later)) - static_cast<double>(ToNanoseconds(earlier))) *
         1e-9;
}

bool IsFinite(const MapFix& fix) {
  return fix.vo_from_device.translation().allFinite() &&
         fix.vo_from_device.rotation().coeffs().allFinite() &&
         fix.map_from_device.translation().allFinite() &&
         fix.map_from_device.rotation().coeffs().allFinite() && fix.covariance.allFinite();
}

// The inverse of a covariance with a floor; one that is not positive counts as the floor alone.
Eigen::Matrix3d Information(const Eigen::Matrix3d& covariance, double sigma_floor) {
  const Eigen::Matrix3d floor = sigma_floor * sigma_floor * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d symmetric = (covariance + covariance.transpose()) / 2;
  const Eigen::LLT<Eigen::Matrix3d> factor(symmetric + floor);
  if (factor.info() != Eigen::Success) return floor.inverse();
  return factor.solve(Eigen::Matrix3d::Identity());
}

internal::WeightedFix Weigh(const MapFix& fix, const MapFix& newest, DeviceTime now,
                            const AlignmentOptions& options) {
  const double age_s = std::max(0.0, SecondsBetween(fix.time, now));
  const double halvings = std::min(kMaxHalvings, age_s / options.half_life.count());
  const double drift_m =
      options.drift_share *
      (newest.vo_from_device.translation() - fix.vo_from_device.translation()).norm();
  return {
      .position_in_vo = fix.vo_from_device.translation(),
      .position_in_map = fix.map_from_device.translation(),
      .map_from_vo_rotation =
          fix.map_from_device.rotation() * fix.vo_from_device.rotation().conjugate(),
      .position_information = Information(fix.covariance.topLeftCorner<3, 3>(),
                                          std::hypot(options.sigma_floor_m, drift_m)),
      .rotation_information = Information(fix.covariance.bottomRightCorner<3, 3>(),
                                          options.sigma_floor_angle.radians()),
      .weight = std::exp2(-halvings),
  };
}

}  // namespace

Result<void> AlignmentOptions::Validate() const {
  const auto positive = [](const char* name, double value) -> Result<void> {
    if (std::isfinite(value) && value > 0) return {};
    return MakeError(ErrorCode::kInvalidArgument, "alignment options: expected {} > 0, found {}",
                     name, value);
  };
  WAYMARK_TRY(positive("half_life", half_life.count()));
  if (!std::isfinite(drift_share) || drift_share < 0) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "alignment options: expected drift_share >= 0, found {}", drift_share);
  }
  WAYMARK_TRY(positive("huber_m", huber_m));
  WAYMARK_TRY(positive("max_disagreement_m", max_disagreement_m));
  WAYMARK_TRY(positive("stale_after", stale_after.count()));
  WAYMARK_TRY(positive("sigma_floor_m", sigma_floor_m));
  WAYMARK_TRY(positive("sigma_floor_angle", sigma_floor_angle.radians()));
  WAYMARK_TRY(positive("max_disagreement_angle", max_disagreement_angle.radians()));
  if (max_fixes < 1 || max_fixes > 1000) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "alignment options: expected max_fixes in [1, 1000], found {}", max_fixes);
  }
  if (min_supporting_fixes < 1) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "alignment options: expected min_supporting_fixes >= 1, found {}",
                     min_supporting_fixes);
  }
  return {};
}

OdometryAlignment::OdometryAlignment(const AlignmentOptions& options) : options_(options) {
  const Result<void> valid = options_.Validate();
  CHECK(valid.ok(), "{}", ToString(valid.error()));
}

void OdometryAlignment::AddFix(const MapFix& fix) {
  if (!IsFinite(fix)) return;
  if (!fixes_.empty() &&
      SecondsBetween(fix.time, fixes_.back().time) > options_.stale_after.count()) {
    fixes_.clear();
  }
  const auto place =
      std::lower_bound(fixes_.begin(), fixes_.end(), fix.time,
                       [](const MapFix& known, DeviceTime time) { return known.time < time; });
  if (place != fixes_.end() && place->time == fix.time) {
    *place = fix;
    return;
  }
  fixes_.insert(place, fix);
  if (fixes_.size() > options_.max_fixes) fixes_.pop_front();
}

void OdometryAlignment::ShiftTime(std::chrono::nanoseconds by) {
  for (MapFix& fix : fixes_) fix.time += by;
}

void OdometryAlignment::ResetOdometry() { fixes_.clear(); }

std::optional<Transform<Map, Map>> OdometryAlignment::CarryTo(
    const std::map<SubmapId, Similarity<Map, Submap>>& placements) {
  std::erase_if(fixes_, [&](const MapFix& fix) { return !placements.contains(fix.submap); });
  std::optional<Transform<Map, Map>> motion;
  for (MapFix& fix : fixes_) {  // oldest first: the newest has the last word
    const Transform<Map, Device> before = fix.map_from_device;
    fix.map_from_device =
        CarryPose(placements.at(fix.submap), fix.submap_from_camera) * fix.camera_from_device;
    motion = fix.map_from_device * before.Inverse();
  }
  return motion;
}

Alignment OdometryAlignment::Estimate(DeviceTime now) const {
  if (fixes_.empty()) return {};
  std::vector<internal::WeightedFix> weighted;
  weighted.reserve(fixes_.size());
  for (const MapFix& fix : fixes_) weighted.push_back(Weigh(fix, fixes_.back(), now, options_));
  const internal::Consensus consensus = internal::FindConsensus(weighted, options_);

  const auto supporting = static_cast<int>(consensus.supporters.size());
  const DeviceTime newest = fixes_[consensus.supporters.back()].time;
  const bool is_old = std::abs(SecondsBetween(newest, now)) > options_.stale_after.count();
  const bool is_agreed =
      supporting >= options_.min_supporting_fixes && consensus.supporting_share > 0.5;
  return {
      .state = is_old      ? AlignmentState::kStale
               : is_agreed ? AlignmentState::kFixed
                           : AlignmentState::kCoarse,
      .map_from_vo = Transform<Map, Vo>(consensus.map_from_vo),
      .covariance = consensus.covariance,
      .supporting_fixes = supporting,
      .contradicting_fixes = static_cast<int>(fixes_.size()) - supporting,
  };
}

}  // namespace waymark::localiser

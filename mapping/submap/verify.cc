// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/base/median.h"
#include "mapping/submap/internal/findings.h"

namespace waymark::mapping {
namespace {

using internal::Findings;
using internal::Tally;

// How many checks one wrong image breaks: pairs, changes between two pairs.
constexpr double kPerPair = 2;
constexpr double kPerChange = 3;
constexpr double kMaxGnssM = 10;

/// A motion that no body, or no vehicle, can have made.
std::optional<std::string> FindMotionFault(const Findings& found,
                                           const VerificationOptions& options) {
  if (found.speed.Fails(options.tolerated_share)) {
    return fmt::format("{} of {} steps are faster than {:.0f} m/s, up to {:.1f} m/s",
                       found.speed.broken, found.speed.count, options.max_speed_mps,
                       found.speed.worst);
  }
  const auto describe = [](const Tally& tally, const char* what, const char* unit) {
    return fmt::format("{} of {} {}, up to {:.2f} {}", tally.broken, tally.count, what, tally.worst,
                       unit);
  };
  if (found.tear.broken > 0) return describe(found.tear, "steps tear the path", "m/s");
  if (found.acceleration.Fails(kPerChange * options.tolerated_share)) {
    return describe(found.acceleration, "changes of velocity are too fast", "m/s");
  }
  if (found.sideways.Fails(kPerPair * options.tolerated_share)) {
    return describe(found.sideways, "steps of the vehicle are sideways", "rad");
  }
  if (found.curvature.Fails(kPerPair * options.tolerated_share)) {
    return describe(found.curvature, "turns of the vehicle are too tight", "1/m");
  }
  if (found.yaw_rate.Fails(kPerChange * options.tolerated_share)) {
    return describe(found.yaw_rate, "turns of the path are not the vehicle's", "rad/s");
  }
  return std::nullopt;
}

/// What needs up and metres.
std::optional<std::string> FindMetricFault(const Findings& found,
                                           const VerificationOptions& options) {
  if (!found.gravity_rad.empty() && Median(found.gravity_rad) > options.max_gravity_error_rad) {
    return fmt::format("leans by {:.3f} rad (median) from the accelerometer's vertical",
                       Median(found.gravity_rad));
  }
  if (found.worst_gravity_rad > options.max_gravity_error_rad) {
    return fmt::format("a third of it leans by {:.3f} rad (median) from the vertical",
                       found.worst_gravity_rad);
  }
  if (auto fault = FindMotionFault(found, options)) return fault;
  if (found.scale_drift.broken > 0) {
    return fmt::format("its scale drifts against GNSS{}, by up to {:.2f} m (bound {:.2f} m)",
                       found.road_drift.count > 0 ? " and the road" : "", found.scale_drift.worst,
                       found.scale_drift.bound);
  }
  if (found.bend.broken > 0) {
    return fmt::format("is bent against GNSS, by up to {:.2f} m (bound {:.2f} m)", found.bend.worst,
                       found.bend.bound);
  }
  if (found.gnss_lie.broken == 0 && !found.gnss_m.empty() && Median(found.gnss_m) > kMaxGnssM &&
      Median(found.gnss_sigmas) > options.max_gnss_sigmas) {
    return fmt::format("is {:.1f} m (median) away from GNSS, {:.1f} sigma", Median(found.gnss_m),
                       Median(found.gnss_sigmas));
  }
  return std::nullopt;
}

/// The first broken bound, as a sentence.
std::optional<std::string> FindFault(const Reconstruction& reconstruction, const Findings& found,
                                     const VerificationOptions& options) {
  if (found.registered < options.min_images ||
      found.owned_registered < options.min_registered_share * found.owned) {
    return fmt::format("too few images joined: {} of {} own ones, {} in all",
                       found.owned_registered, found.owned, found.registered);
  }
  if (reconstruction.points.size() < static_cast<std::size_t>(options.min_landmarks)) {
    return fmt::format("too few landmarks: {}", reconstruction.points.size());
  }
  if (!(reconstruction.mean_reprojection_px <= options.max_mean_reprojection_px)) {
    return fmt::format("mean reprojection error of {:.2f} px exceeds {:.2f} px",
                       reconstruction.mean_reprojection_px, options.max_mean_reprojection_px);
  }
  if (found.gyroscope.Fails(options.tolerated_share)) {
    return fmt::format("{} of {} relative rotations contradict the gyroscope, by up to {:.3f} rad",
                       found.gyroscope.broken, found.gyroscope.count, found.gyroscope.worst);
  }
  if (found.drift.Fails(options.tolerated_share)) {
    return fmt::format("{} of {} orientations drift from the gyroscope, by up to {:.3f} rad",
                       found.drift.broken, found.drift.count, found.drift.worst);
  }
  if (found.bias.broken > 0) {
    return fmt::format("turns steadily against the gyroscope, by {:.4f} rad/s", found.bias.worst);
  }
  // Without alignment neither up nor metres are known.
  return reconstruction.is_geo_aligned ? FindMetricFault(found, options) : std::nullopt;
}

std::string DescribeChecks(const Reconstruction& reconstruction, const Findings& found) {
  std::string text = fmt::format(
      "{} of {} own images and {} borrowed ones joined, {:.2f} px", found.owned_registered,
      found.owned, found.registered - found.owned_registered, reconstruction.mean_reprojection_px);
  text += found.gyroscope.count > 0
              ? fmt::format("; gyroscope within {:.4f} rad", found.gyroscope.worst)
              : std::string("; no gyroscope");
  if (found.drift.count > 0) {
    text += fmt::format(", drift {:.4f} rad beside a bias of {:.4f} rad/s", found.drift.worst,
                        found.bias.worst);
  }
  if (!reconstruction.is_geo_aligned) return text + "; not geo-aligned";
  text += found.gravity_rad.empty()
              ? std::string("; gravity unknown")
              : fmt::format("; gravity {:.4f} rad (median)", Median(found.gravity_rad));
  text += found.is_vehicle
              ? fmt::format("; a vehicle, sideways within {:.3f} rad", found.sideways.worst)
              : std::string("; no vehicle");
  if (found.scale_drift.count > 0) {
    text += fmt::format("; scale drift {:.2f} m", found.scale_drift.worst);
  }
  if (found.gnss_lie.broken > 0) {
    text += fmt::format("; GNSS is wrong by {:.1f} m and not followed", found.gnss_lie.worst);
  }
  if (!found.gnss_m.empty()) text += fmt::format("; GNSS {:.2f} m (median)", Median(found.gnss_m));
  return text;
}

}  // namespace

Result<void> VerificationOptions::Validate() const {
  const bool positive = max_mean_reprojection_px > 0 && max_gyroscope_error_rad > 0 &&
                        max_gyroscope_drift_rad_per_s >= 0 && max_gravity_error_rad > 0 &&
                        max_speed_mps > 0 && max_gnss_sigmas > 0;
  const bool drift = gyroscope_bias_sigma_rad_per_s > 0 && max_gyroscope_bias_rad_per_s > 0 &&
                     max_rotation_drift_rad > 0 && max_gyroscope_scale_error >= 0;
  const bool motion = max_acceleration_mps2 > 0 && position_tolerance_m >= 0 && min_step_m > 0 &&
                      min_vehicle_speed_mps > 0 && max_slip_rad > 0 && max_lever_arm_m >= 0 &&
                      min_turning_radius_m > 0 && max_yaw_rate_error_rad_per_s > 0 &&
                      max_shape_error_m > 0 && max_shape_sigmas >= 0;
  const bool shares = min_registered_share >= 0 && min_registered_share <= 1 &&
                      tolerated_share >= 0 && tolerated_share < 1 && min_vehicle_share >= 0 &&
                      min_vehicle_share <= 1;
  if (!positive || !drift || !motion || !shares || min_images < 2 || min_landmarks < 0) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "verification options: expected positive bounds, shares within 0 and 1, "
                     "min_images >= 2 and min_landmarks >= 0");
  }
  return {};
}

Result<VerificationEvidence> VerifyReconstruction(const Reconstruction& reconstruction,
                                                  std::span<const VerificationImage> images,
                                                  std::span<const MeasuredRotation> rotations,
                                                  const VerificationOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY(internal::CheckVerificationInput(reconstruction, images, rotations));
  const Findings found = internal::MeasureAll(reconstruction, images, rotations, options);
  const std::optional<std::string> fault = FindFault(reconstruction, found, options);
  VerificationEvidence evidence;
  evidence.accepted = !fault;
  evidence.verdict =
      fault ? "rejected: " + *fault : "accepted: " + DescribeChecks(reconstruction, found);
  evidence.figures = internal::ListFigures(reconstruction, found, options);
  evidence.gnss_is_trusted = found.gnss_lie.broken == 0;
  evidence.max_gyroscope_error_rad = found.gyroscope.worst;
  evidence.mean_reprojection_px = reconstruction.mean_reprojection_px;
  if (reconstruction.is_geo_aligned) {
    evidence.max_speed_mps = found.speed.worst;
    if (!found.gravity_rad.empty()) {
      evidence.max_gravity_error_rad = *std::ranges::max_element(found.gravity_rad);
    }
  }
  return evidence;
}

}  // namespace waymark::mapping

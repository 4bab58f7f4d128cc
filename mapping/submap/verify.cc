// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/submap/internal/measurements.h"

namespace waymark::mapping {
namespace {

using internal::Median;

/// One check: its worst figure, how many values broke the bound, of how many.
struct Tally {
  double worst = 0;
  int broken = 0;
  int count = 0;

  void Add(double value, double bound) {
    worst = std::max(worst, value);
    broken += value > bound ? 1 : 0;
    ++count;
  }
  bool Fails(double tolerated_share) const { return broken > tolerated_share * count; }
};

/// Everything measured about one reconstruction.
struct Findings {
  int registered = 0;
  int owned = 0;
  int owned_registered = 0;
  Tally gyroscope;
  Tally speed;
  std::vector<double> gravity_rad;
  std::vector<double> gnss_m;
  std::vector<double> gnss_sigmas;
};

void CountImages(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
                 Findings& findings) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    const bool is_registered = reconstruction.images[i].submap_from_camera.has_value();
    findings.registered += is_registered;
    findings.owned += !images[i].is_borrowed;
    findings.owned_registered += is_registered && !images[i].is_borrowed;
  }
}

void TallyPairs(std::span<const internal::PairCheck> checks, Tally& tally) {
  for (const internal::PairCheck& check : checks) tally.Add(check.value, check.bound);
}

void MeasureImages(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
                   Findings& findings) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto& pose = reconstruction.images[i].submap_from_camera;
    if (!pose) continue;
    if (images[i].up_in_camera) {
      const Eigen::Vector3d up = pose->rotation() * *images[i].up_in_camera;
      findings.gravity_rad.push_back(std::atan2(up.head<2>().norm(), up.z()));
    }
    if (images[i].gnss_in_submap) {
      const double off_m = (pose->translation() - images[i].gnss_in_submap->coordinates()).norm();
      findings.gnss_m.push_back(off_m);
      findings.gnss_sigmas.push_back(off_m / images[i].gnss_sigma_m);
    }
  }
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
  if (!reconstruction.is_geo_aligned) return std::nullopt;  // neither up nor metres are known
  if (!found.gravity_rad.empty() && Median(found.gravity_rad) > options.max_gravity_error_rad) {
    return fmt::format("leans by {:.3f} rad (median) from the accelerometer's vertical",
                       Median(found.gravity_rad));
  }
  if (found.speed.Fails(options.tolerated_share)) {
    return fmt::format("{} of {} steps are faster than {:.0f} m/s, up to {:.1f} m/s",
                       found.speed.broken, found.speed.count, options.max_speed_mps,
                       found.speed.worst);
  }
  if (!found.gnss_m.empty() && Median(found.gnss_m) > 10 &&
      Median(found.gnss_sigmas) > options.max_gnss_sigmas) {
    return fmt::format("is {:.1f} m (median) away from GNSS, {:.1f} sigma", Median(found.gnss_m),
                       Median(found.gnss_sigmas));
  }
  return std::nullopt;
}

std::string DescribeChecks(const Reconstruction& reconstruction, const Findings& found) {
  std::string text = fmt::format(
      "{} of {} own images and {} borrowed ones joined, {:.2f} px", found.owned_registered,
      found.owned, found.registered - found.owned_registered, reconstruction.mean_reprojection_px);
  text += found.gyroscope.count > 0
              ? fmt::format("; gyroscope within {:.4f} rad", found.gyroscope.worst)
              : std::string("; no gyroscope");
  if (!reconstruction.is_geo_aligned) return text + "; not geo-aligned";
  text += found.gravity_rad.empty()
              ? std::string("; gravity unknown")
              : fmt::format("; gravity {:.4f} rad (median)", Median(found.gravity_rad));
  if (!found.gnss_m.empty()) text += fmt::format("; GNSS {:.2f} m (median)", Median(found.gnss_m));
  return text;
}

}  // namespace

Result<void> VerificationOptions::Validate() const {
  const bool positive = max_mean_reprojection_px > 0 && max_gyroscope_error_rad > 0 &&
                        max_gyroscope_drift_rad_per_s >= 0 && max_gravity_error_rad > 0 &&
                        max_speed_mps > 0 && max_gnss_sigmas > 0;
  const bool shares = min_registered_share >= 0 && min_registered_share <= 1 &&
                      tolerated_share >= 0 && tolerated_share < 1;
  if (!positive || !shares || min_images < 2 || min_landmarks < 0) {
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
  Findings found;
  CountImages(reconstruction, images, found);
  TallyPairs(internal::CompareRotations(reconstruction, rotations, options), found.gyroscope);
  TallyPairs(internal::MeasureSpeeds(reconstruction, images, options), found.speed);
  MeasureImages(reconstruction, images, found);

  const std::optional<std::string> fault = FindFault(reconstruction, found, options);
  VerificationEvidence evidence;
  evidence.accepted = !fault;
  evidence.verdict =
      fault ? "rejected: " + *fault : "accepted: " + DescribeChecks(reconstruction, found);
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

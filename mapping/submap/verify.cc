// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace waymark::mapping {
namespace {

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

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

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

void CheckRotations(const Reconstruction& reconstruction,
                    std::span<const MeasuredRotation> rotations, const VerificationOptions& options,
                    Findings& findings) {
  for (const MeasuredRotation& measured : rotations) {
    const auto& from = reconstruction.images[measured.from].submap_from_camera;
    const auto& to = reconstruction.images[measured.to].submap_from_camera;
    if (!from || !to) continue;
    const Eigen::Quaterniond found = to->rotation().conjugate() * from->rotation();
    findings.gyroscope.Add(
        AngleBetween(found, measured.to_from_from).radians(),
        options.max_gyroscope_error_rad + options.max_gyroscope_drift_rad_per_s * measured.seconds);
  }
}

void CheckPositions(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
                    const VerificationOptions& options, Findings& findings) {
  std::map<std::string, std::vector<std::pair<SensorTime, Eigen::Vector3d>>> sequences;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto& pose = reconstruction.images[i].submap_from_camera;
    if (!pose) continue;
    if (images[i].up_in_camera) {
      const Eigen::Vector3d up = pose->rotation() * *images[i].up_in_camera;
      findings.gravity_rad.push_back(std::atan2(up.head<2>().norm(), up.z()));
    }
    sequences[images[i].sequence].emplace_back(images[i].time, pose->translation());
    if (images[i].gnss_in_submap) {
      const double off_m = (pose->translation() - images[i].gnss_in_submap->coordinates()).norm();
      findings.gnss_m.push_back(off_m);
      findings.gnss_sigmas.push_back(off_m / images[i].gnss_sigma_m);
    }
  }
  for (auto& [sequence, sightings] : sequences) {
    std::stable_sort(sightings.begin(), sightings.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 1; i < sightings.size(); ++i) {
      const double seconds = Seconds(sightings[i].first - sightings[i - 1].first);
      if (seconds <= 0) continue;
      const double metres = (sightings[i].second - sightings[i - 1].second).norm();
      findings.speed.Add(metres / seconds, options.max_speed_mps);
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
              ? std::string("; no accelerometer")
              : fmt::format("; gravity {:.4f} rad (median)", Median(found.gravity_rad));
  if (!found.gnss_m.empty()) text += fmt::format("; GNSS {:.2f} m (median)", Median(found.gnss_m));
  return text;
}

Result<void> CheckInput(const Reconstruction& reconstruction,
                        std::span<const VerificationImage> images,
                        std::span<const MeasuredRotation> rotations) {
  if (images.size() != reconstruction.images.size()) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "verification: {} images for a reconstruction of {}", images.size(),
                     reconstruction.images.size());
  }
  for (const MeasuredRotation& rotation : rotations) {
    if (std::max(rotation.from, rotation.to) >= images.size()) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "verification: rotation between images {} and {}", rotation.from,
                       rotation.to);
    }
  }
  return {};
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
  WAYMARK_TRY(CheckInput(reconstruction, images, rotations));
  Findings found;
  CountImages(reconstruction, images, found);
  CheckRotations(reconstruction, rotations, options, found);
  CheckPositions(reconstruction, images, options, found);

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

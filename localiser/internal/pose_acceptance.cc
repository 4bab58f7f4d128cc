// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/pose_acceptance.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>

#include "mapping/geometry/angle.h"

namespace waymark::localiser::internal {
namespace {

constexpr double kMaxLogFalsePoses = -4;  // one false pose in ten thousand images
// Features and projected landmarks crowd together, so that wrong matches hit more often than if
// both were spread evenly over the image.
constexpr double kCrowding = 4;
constexpr double kMaxFocalSigmas = 2.5;  // beyond its doubt, the lens is not the one stated
constexpr std::size_t kMinGridCells = 5;
constexpr double kMaxRelativeSigma = 0.05;  // of the distance, so that local maps need no metre

// A false pose is off by more than 1 m or 5 degrees. Four standard deviations must be less, since
// the errors of poses from few matches have longer tails than a normal distribution.
constexpr double kMaxSigmaM = 0.25;
constexpr Angle kMaxSigma = Angle::Degrees(1.25);

double LargestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues().maxCoeff());
}

double LogBinomial(std::size_t n, std::size_t k) {
  const auto log_factorial = [](std::size_t x) { return std::lgamma(static_cast<double>(x) + 1); };
  return (log_factorial(n) - log_factorial(k) - log_factorial(n - k)) / std::numbers::ln10;
}

std::size_t CountGridCells(std::span<const Eigen::Vector2d> pixels_px, const CameraModel& camera) {
  std::bitset<kImageParts * kImageParts> touched;
  for (const Eigen::Vector2d& pixel_px : pixels_px) {
    const auto cell = [](double position, int size) {
      return std::clamp(static_cast<int>(kImageParts * position / size), 0, kImageParts - 1);
    };
    touched.set(static_cast<std::size_t>(cell(pixel_px.y(), camera.height_px()) * kImageParts +
                                         cell(pixel_px.x(), camera.width_px())));
  }
  return touched.count();
}

}  // namespace

double LogExpectedFalsePoses(std::size_t matches, std::size_t inliers, double chance) {
  constexpr std::size_t kSample = 3;
  if (inliers <= kSample || matches <= kSample) return std::log10(static_cast<double>(matches) + 1);
  return std::log10(static_cast<double>(matches - kSample)) + LogBinomial(matches, inliers) +
         LogBinomial(inliers, kSample) +
         static_cast<double>(inliers - kSample) * std::log10(std::min(1.0, chance));
}

std::optional<std::string> FindLensContradiction(std::size_t inliers, double focal_factor,
                                                 double focal_sigma_share) {
  if (std::abs(focal_factor - 1) <= kMaxFocalSigmas * focal_sigma_share) return std::nullopt;
  return fmt::format("{} inliers contradict the stated focal length: they fit with {:.2f} times it",
                     inliers, focal_factor);
}

std::optional<std::string> FindDoubt(const Eigen::Matrix<double, 6, 6>& covariance,
                                     bool is_map_in_metres) {
  const double sigma_m = LargestSigma(covariance.topLeftCorner<3, 3>());
  const Angle sigma = Angle::Radians(LargestSigma(covariance.bottomRightCorner<3, 3>()));
  if (!(sigma_m <= kMaxSigmaM) && is_map_in_metres) {
    return fmt::format("the position is uncertain by {:.2f} m, at most {}", sigma_m, kMaxSigmaM);
  }
  if (!(sigma <= kMaxSigma)) {
    return fmt::format("the direction is uncertain by {:.2f} degrees, at most {}", sigma.degrees(),
                       kMaxSigma.degrees());
  }
  return std::nullopt;
}

double ChanceOfInlier(double max_error_px, const CameraModel& camera) {
  const double area_px2 = double{1} * camera.width_px() * camera.height_px();
  return kCrowding * std::numbers::pi * max_error_px * max_error_px / area_px2;
}

std::optional<std::string> FindReasonToRefuse(const PoseEvidence& evidence,
                                              const CameraModel& camera) {
  return FindReasonToRefuse(CountedEvidence{.matches = evidence.matches,
                                            .inliers = evidence.inliers_px.size(),
                                            .chance = ChanceOfInlier(evidence.max_error_px, camera),
                                            .parts = CountGridCells(evidence.inliers_px, camera),
                                            .position_covariance = evidence.position_covariance,
                                            .median_distance_m = evidence.median_distance_m});
}

std::optional<std::string> FindReasonToRefuse(const CountedEvidence& evidence) {
  const double log_false =
      LogExpectedFalsePoses(evidence.matches, evidence.inliers, evidence.chance);
  if (log_false > kMaxLogFalsePoses) {
    return fmt::format(
        "{} inliers among {} matches may be chance (1e{:.1f} expected, at most 1e{})",
        evidence.inliers, evidence.matches, log_false, kMaxLogFalsePoses);
  }
  if (evidence.parts < kMinGridCells) {
    return fmt::format("{} inliers touch only {} of {} parts of the image, {} are needed",
                       evidence.inliers, evidence.parts, kImageParts * kImageParts, kMinGridCells);
  }
  const double sigma_m = LargestSigma(evidence.position_covariance);
  if (!(sigma_m <= kMaxRelativeSigma * evidence.median_distance_m)) {
    return fmt::format("{} inliers at {:.1f} m leave the position uncertain by {:.2f} m",
                       evidence.inliers, evidence.median_distance_m, sigma_m);
  }
  return std::nullopt;
}

}  // namespace waymark::localiser::internal

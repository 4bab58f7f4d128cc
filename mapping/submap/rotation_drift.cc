// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/internal/rotation_drift.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "mapping/base/median.h"

namespace waymark::mapping::internal {
namespace {

constexpr double kRotationSigmaRad = 0.005;  // of a reconstructed orientation
constexpr std::size_t kMinImages = 4;        // fewer have no shape

/// One image of a run.
struct Stand {
  std::uint32_t image;
  double seconds;                                  ///< since the run began
  double turned_rad;                               ///< by the gyroscope, since the run began
  Eigen::Quaterniond submap_from_first;            ///< what this image says about the first camera
  Eigen::Matrix3d felt = Eigen::Matrix3d::Zero();  ///< drift in the submap per unit of bias
};

using Run = std::vector<Stand>;

Run FollowRun(const Reconstruction& reconstruction,
              const std::map<std::uint32_t, const MeasuredRotation*>& next_of,
              std::uint32_t first) {
  Run run;
  Eigen::Quaterniond now_from_first = Eigen::Quaterniond::Identity();
  Stand stand{first, 0, 0, reconstruction.images[first].submap_from_camera->rotation()};
  run.push_back(stand);
  for (auto next = next_of.find(first); next != next_of.end();
       next = next_of.find(next->second->to)) {
    const MeasuredRotation& turn = *next->second;
    const Eigen::Quaterniond before =
        reconstruction.images[turn.from].submap_from_camera->rotation();
    const Eigen::Quaterniond after = reconstruction.images[turn.to].submap_from_camera->rotation();
    now_from_first = turn.to_from_from * now_from_first;
    stand.image = turn.to;
    stand.seconds += turn.seconds;
    stand.turned_rad += VectorFromRotation(turn.to_from_from).norm();
    stand.submap_from_first = after * now_from_first;
    stand.felt += 0.5 * turn.seconds * (before.toRotationMatrix() + after.toRotationMatrix());
    run.push_back(stand);
    if (run.size() > next_of.size() + 1) break;  // rotations that bite their tail
  }
  return run;
}

/// The orientation nearest to most of the others.
Eigen::Quaterniond FindCentre(const Run& run) {
  constexpr std::size_t kCandidates = 40;
  const std::size_t stride = 1 + run.size() / kCandidates;
  Eigen::Quaterniond best = run.front().submap_from_first;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < run.size(); i += stride) {
    std::vector<double> angles;
    for (const Stand& other : run) {
      angles.push_back(AngleBetween(run[i].submap_from_first, other.submap_from_first).radians());
    }
    const double median = Median(std::move(angles));
    if (median < least) std::tie(least, best) = std::pair(median, run[i].submap_from_first);
  }
  return best;
}

/// A constant orientation and a constant bias, fitted robustly; the bias has a prior.
Eigen::Matrix<double, 6, 1> FitBias(const Run& run, std::span<const Eigen::Vector3d> errors,
                                    const VerificationOptions& options) {
  constexpr int kIterations = 8;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  Eigen::Matrix<double, 6, 1> fit = Eigen::Matrix<double, 6, 1>::Zero();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Matrix6 normal = Matrix6::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t k = 0; k < run.size(); ++k) {
      Eigen::Matrix<double, 3, 6> row;
      row << Eigen::Matrix3d::Identity(), run[k].felt;
      const double off = (errors[k] - row * fit).norm() / kRotationSigmaRad;
      const double weight =
          (iteration == 0 ? 1 : 1 / std::max(1.0, off)) / (kRotationSigmaRad * kRotationSigmaRad);
      normal += weight * row.transpose() * row;
      right += weight * row.transpose() * errors[k];
    }
    const double sigma = options.gyroscope_bias_sigma_rad_per_s;
    normal.bottomRightCorner<3, 3>().diagonal().array() += 1 / (sigma * sigma);
    normal.topLeftCorner<3, 3>().diagonal().array() += 1e-6;
    fit = normal.ldlt().solve(right);
  }
  return fit;
}

RotationDrift Judge(const Run& run, const VerificationOptions& options) {
  const Eigen::Quaterniond centre = FindCentre(run);
  std::vector<Eigen::Vector3d> errors;
  for (const Stand& stand : run) {
    errors.push_back(VectorFromRotation(stand.submap_from_first * centre.conjugate()));
  }
  const Eigen::Matrix<double, 6, 1> fit = FitBias(run, errors, options);
  RotationDrift drift;
  drift.bias_rad_per_s = fit.tail<3>();
  const double middle_rad = run[run.size() / 2].turned_rad;
  for (std::size_t k = 0; k < run.size(); ++k) {
    const Eigen::Vector3d rest = errors[k] - fit.head<3>() - run[k].felt * fit.tail<3>();
    drift.checks.push_back(
        {run[k].image, run[k].image, rest.norm(),
         options.max_rotation_drift_rad +
             options.max_gyroscope_scale_error * std::abs(run[k].turned_rad - middle_rad)});
    drift.images.push_back(run[k].image);
  }
  return drift;
}

}  // namespace

std::vector<RotationDrift> MeasureRotationDrift(const Reconstruction& reconstruction,
                                                std::span<const MeasuredRotation> rotations,
                                                const VerificationOptions& options) {
  std::map<std::uint32_t, const MeasuredRotation*> next_of;
  std::set<std::uint32_t> followers;
  for (const MeasuredRotation& rotation : rotations) {
    if (!reconstruction.images[rotation.from].submap_from_camera ||
        !reconstruction.images[rotation.to].submap_from_camera) {
      continue;
    }
    next_of[rotation.from] = &rotation;
    followers.insert(rotation.to);
  }
  std::vector<RotationDrift> drifts;
  for (const auto& [first, next] : next_of) {
    if (followers.contains(first)) continue;
    const Run run = FollowRun(reconstruction, next_of, first);
    if (run.size() >= kMinImages) drifts.push_back(Judge(run, options));
  }
  return drifts;
}

}  // namespace waymark::mapping::internal

// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/two_view.h"

#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <opengv/relative_pose/modules/main.hpp>
#include <utility>

#include "mapping/base/median.h"
#include "mapping/estimation/epipolar_table.h"
#include "mapping/estimation/essential.h"
#include "mapping/estimation/homography.h"
#include "mapping/estimation/robust_loop.h"

namespace waymark::mapping {
namespace {

class EssentialFromMatches {
 public:
  using Model = Eigen::Matrix3d;
  static constexpr std::size_t kSampleSize = 5;

  EssentialFromMatches(std::span<const NormalizedMatch> matches, double max_error_px)
      : matches_(matches), max_error_px_(max_error_px) {
    const auto squared_threshold = [&](double per_px) {
      return static_cast<float>(max_error_px * max_error_px * per_px * per_px);
    };
    for (const NormalizedMatch& match : matches) {
      const Eigen::Vector2f a = match.first.cast<float>();
      const Eigen::Vector2f b = match.second.cast<float>();
      table_.Add({a.x(), a.y(), b.x(), b.y(), squared_threshold(match.first_per_px),
                  squared_threshold(match.second_per_px)});
    }
    table_.Pad();
  }

  std::size_t size() const { return matches_.size(); }

  void Solve(std::span<const std::uint32_t> sample, std::vector<Model>& models) const {
    // Each match is one equation in the nine entries of E, row by row; the solver wants a basis
    // of the four-dimensional space that solves all five.
    Eigen::Matrix<double, 9, 5> equations;
    for (std::size_t k = 0; k < kSampleSize; ++k) {
      const Eigen::Vector3d a = matches_[sample[k]].first.homogeneous();
      const Eigen::Vector3d b = matches_[sample[k]].second.homogeneous();
      equations.col(static_cast<Eigen::Index>(k)) << a.x() * b, a.y() * b, a.z() * b;
    }
    const Eigen::Matrix<double, 9, 9> orthogonal = equations.householderQr().householderQ();
    solutions_.clear();
    opengv::relative_pose::modules::fivept_stewenius_main(orthogonal.rightCols<4>(), solutions_);
    for (const auto& solution : solutions_) {
      const Eigen::Matrix3d real = solution.real();
      if (!real.allFinite() || solution.imag().norm() > 1e-6 * real.norm()) continue;
      models.push_back(real.normalized());
    }
  }

  double Cost(const Model& essential, double /*limit*/) const {
    const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> rows = essential.cast<float>();
    return static_cast<double>(table_.TruncatedCost(rows.data()));
  }

  void CollectInliers(const Model& essential, double bound,
                      std::vector<std::uint32_t>& inliers) const {
    inliers.clear();
    const double max_squared = bound * max_error_px_ * max_error_px_;
    for (std::size_t i = 0; i < size(); ++i) {
      if (SquaredSampsonErrorPx(essential, matches_[i]) < max_squared) {
        inliers.push_back(static_cast<std::uint32_t>(i));
      }
    }
  }

  std::optional<Model> Refine(const Model& essential,
                              std::span<const std::uint32_t> inliers) const {
    const auto pose = PoseFromEssential(essential, matches_, inliers);
    if (!pose) return std::nullopt;
    return EssentialFromPose(RefineRelativePose(*pose, matches_, inliers, max_error_px_ / 2))
        .normalized();
  }

 private:
  std::span<const NormalizedMatch> matches_;
  double max_error_px_;
  EpipolarTable table_;
  mutable opengv::complexEssentials_t solutions_;  // scratch of Solve
};

double MedianRayAngle(const Rigid3& first_from_second, std::span<const NormalizedMatch> matches,
                      std::span<const std::uint32_t> chosen) {
  std::vector<double> angles;
  angles.reserve(chosen.size());
  for (std::uint32_t i : chosen) angles.push_back(RayAngle(first_from_second, matches[i]));
  return Median(std::move(angles));
}

// Points behind a camera satisfy the epipolar constraint but no scene.
void DropPointsBehind(const Rigid3& first_from_second, std::span<const NormalizedMatch> matches,
                      std::vector<std::uint32_t>& inliers) {
  std::erase_if(inliers, [&](std::uint32_t i) {
    const auto depths = TriangulatedDepths(first_from_second, matches[i]);
    // Rays of distant points may cross behind both cameras by noise alone.
    const bool distant = RayAngle(first_from_second, matches[i]) < 2 * matches[i].first_per_px;
    return !distant && depths && !(depths->x() > 0 && depths->y() > 0);
  });
}

// Shares of the inliers above which the simpler explanation is believed.
constexpr double kRotationShare = 0.9;
constexpr double kPlanarShare = 0.9;

}  // namespace

Result<void> TwoViewOptions::Validate() const {
  if (!(max_error_px > 0) || min_inliers < 5 || !(confidence > 0 && confidence < 1) ||
      max_iterations < 1) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "two views: expected max_error_px > 0, min_inliers >= 5, confidence in "
                     "(0, 1), max_iterations >= 1; found {}, {}, {}, {}",
                     max_error_px, min_inliers, confidence, max_iterations);
  }
  return {};
}

Result<std::optional<TwoViewGeometry>> EstimateTwoView(const CameraModel& first,
                                                       const CameraModel& second,
                                                       std::span<const Eigen::Vector2d> first_px,
                                                       std::span<const Eigen::Vector2d> second_px,
                                                       const TwoViewOptions& options) {
  WAYMARK_TRY(options.Validate());
  if (first_px.size() != second_px.size()) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "two views: expected equally many pixels, found {} and {}", first_px.size(),
                     second_px.size());
  }
  const std::optional<TwoViewGeometry> none;
  const auto min_inliers = static_cast<std::size_t>(options.min_inliers);
  const std::vector<NormalizedMatch> matches = NormalizeMatches(first, second, first_px, second_px);
  const EssentialFromMatches problem(matches, options.max_error_px);
  const auto fit = RunRobustLoop(problem, {},
                                 {.min_inliers = min_inliers,
                                  .confidence = options.confidence,
                                  .max_iterations = options.max_iterations,
                                  .seed = options.seed});
  if (!fit) return none;
  const auto pose = PoseFromEssential(fit->model, matches, fit->inliers);
  if (!pose) return none;

  TwoViewGeometry view;
  view.first_from_second = *pose;
  const auto count = static_cast<double>(fit->inliers.size());
  const Eigen::Quaterniond rotation = EstimateRotation(matches, fit->inliers, options.max_error_px);
  std::vector<std::uint32_t> rotation_inliers =
      RotationInliers(matches, rotation, options.max_error_px);
  if (static_cast<double>(rotation_inliers.size()) > kRotationShare * count) {
    view.kind = TwoViewKind::kRotation;
    view.first_from_second = Rigid3(rotation, Eigen::Vector3d::Zero());
    view.inliers = std::move(rotation_inliers);
    view.homography_share = 1;
    if (view.inliers.size() < min_inliers) return none;
    return std::optional(std::move(view));
  }
  view.inliers = fit->inliers;
  DropPointsBehind(view.first_from_second, matches, view.inliers);
  if (view.inliers.size() < min_inliers) return none;
  view.median_angle_rad = MedianRayAngle(view.first_from_second, matches, view.inliers);
  view.homography_share = static_cast<double>(CountHomographyInliers(
                              matches, view.inliers, options.max_error_px, options.seed)) /
                          static_cast<double>(view.inliers.size());
  if (view.homography_share > kPlanarShare) view.kind = TwoViewKind::kPlanar;
  return std::optional(std::move(view));
}

}  // namespace waymark::mapping

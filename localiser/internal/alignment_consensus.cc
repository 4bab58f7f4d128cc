// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/alignment_consensus.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

#include "mapping/base/check.h"

namespace waymark::localiser::internal {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kMaxIterations = 20;
constexpr int kMaxSelections = 5;
// Between phone's and map's gravity, before fixes tell more: levelled submaps are off by 0.003 to
// 0.005 (median), two real walks past the same places by 0.004 (rms).
constexpr double kTiltSigmaRad = 0.007;

double HuberWeight(double residual, double threshold) {
  return residual <= threshold ? 1 : threshold / residual;
}

/// How the fixes see one alignment.
class Vote {
 public:
  Vote(std::span<const WeightedFix> fixes, const AlignmentOptions& options)
      : fixes_(fixes),
        per_square_metre_(1 / (options.max_disagreement_m * options.max_disagreement_m)),
        min_cosine_(std::cos(options.max_disagreement_angle.radians() / 2)) {}

  bool Agrees(const WeightedFix& fix, const Rigid3& map_from_vo) const {
    return Disagreement(fix, map_from_vo) < 1;
  }

  /// Weighted truncated quadratic: a supporter counts the more the closer it is.
  double Score(const Rigid3& map_from_vo) const {
    double score = 0;
    for (const WeightedFix& fix : fixes_) {
      const double disagreement = Disagreement(fix, map_from_vo);
      if (disagreement < 1) score += fix.weight * (1 - disagreement);
    }
    return score;
  }

  std::vector<std::uint32_t> Supporters(const Rigid3& map_from_vo) const {
    std::vector<std::uint32_t> supporters;
    for (std::uint32_t i = 0; i < fixes_.size(); ++i) {
      if (Agrees(fixes_[i], map_from_vo)) supporters.push_back(i);
    }
    return supporters;
  }

 private:
  // Squared distance over its limit; 1 or more is a contradiction, also by rotation.
  double Disagreement(const WeightedFix& fix, const Rigid3& map_from_vo) const {
    const double distance = (fix.position_in_map - map_from_vo * fix.position_in_vo).squaredNorm();
    const double share = distance * per_square_metre_;
    if (share >= 1) return share;
    // |w| of the relative quaternion is cos(angle / 2).
    const double cosine = std::abs(map_from_vo.rotation().dot(fix.map_from_vo_rotation));
    return cosine > min_cosine_ ? share : 1;
  }

  std::span<const WeightedFix> fixes_;
  double per_square_metre_;
  double min_cosine_;
};

Rigid3 HypothesisOfOne(const WeightedFix& fix, AlignmentFreedom freedom) {
  const Eigen::Quaterniond rotation = freedom == AlignmentFreedom::kFull
                                          ? fix.map_from_vo_rotation
                                          : NearestYaw(fix.map_from_vo_rotation);
  return {rotation, fix.position_in_map - rotation * fix.position_in_vo};
}

// Rotations of single fixes are coarse; two fixes apart give the yaw by their baseline.
std::optional<Rigid3> HypothesisOfTwo(const WeightedFix& a, const WeightedFix& b,
                                      double min_baseline_m) {
  const Eigen::Vector2d in_vo = (b.position_in_vo - a.position_in_vo).head<2>();
  const Eigen::Vector2d in_map = (b.position_in_map - a.position_in_map).head<2>();
  if (in_vo.norm() < min_baseline_m || in_map.norm() < min_baseline_m) return std::nullopt;
  const double yaw = std::atan2(in_map.y(), in_map.x()) - std::atan2(in_vo.y(), in_vo.x());
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d middle_in_vo = (a.position_in_vo + b.position_in_vo) / 2;
  const Eigen::Vector3d middle_in_map = (a.position_in_map + b.position_in_map) / 2;
  return Rigid3(rotation, middle_in_map - rotation * middle_in_vo);
}

Rigid3 BestHypothesis(std::span<const WeightedFix> fixes, const AlignmentOptions& options) {
  const Vote vote(fixes, options);
  Rigid3 best = HypothesisOfOne(fixes.back(), options.freedom);
  double best_score = vote.Score(best);
  const auto consider = [&](const Rigid3& candidate) {
    const double score = vote.Score(candidate);
    if (score > best_score) {
      best_score = score;
      best = candidate;
    }
  };
  for (std::size_t i = fixes.size(); i-- > 0;) {  // newest first: it wins a tie
    consider(HypothesisOfOne(fixes[i], options.freedom));
    if (options.freedom == AlignmentFreedom::kFull) continue;
    for (std::size_t j = 0; j < i; ++j) {
      const auto candidate = HypothesisOfTwo(fixes[j], fixes[i], 2 * options.max_disagreement_m);
      if (candidate) consider(*candidate);
    }
  }
  return best;
}

/// Roll and pitch of an alignment with four freedoms: not to be turned, or only doubted.
enum class Tilt { kSettled, kDoubted };

/// The normal equations of cost (3) at one alignment, rotating about `pivot_in_map`.
struct NormalEquations {
  Matrix6 information = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  double chi_squared = 0;
};

NormalEquations Linearise(std::span<const WeightedFix> fixes,
                          std::span<const std::uint32_t> supporters, const Rigid3& map_from_vo,
                          const Eigen::Vector3d& pivot_in_map, Tilt tilt,
                          const AlignmentOptions& options) {
  NormalEquations equations;
  const bool is_upright = options.freedom == AlignmentFreedom::kYawAndTranslation;
  const bool is_settled = is_upright && tilt == Tilt::kSettled;
  for (const std::uint32_t index : supporters) {
    const WeightedFix& fix = fixes[index];
    const Eigen::Vector3d predicted = map_from_vo * fix.position_in_vo;
    const Eigen::Vector3d residual = fix.position_in_map - predicted;
    const double weight = fix.weight * HuberWeight(residual.norm(), options.huber_m);
    Eigen::Matrix<double, 3, 6> jacobian;  // of the prediction
    jacobian << Eigen::Matrix3d::Identity(), -CrossMatrix(predicted - pivot_in_map);
    const Eigen::Matrix<double, 6, 3> weighted =
        weight * jacobian.transpose() * fix.position_information;
    equations.information += weighted * jacobian;
    equations.gradient += weighted * residual;
    equations.chi_squared += weight * residual.dot(fix.position_information * residual);

    Eigen::Vector3d turn =
        VectorFromRotation(fix.map_from_vo_rotation * map_from_vo.rotation().conjugate());
    if (is_settled) turn.head<2>().setZero();
    const double turn_weight =
        fix.weight * HuberWeight(turn.norm(), 3 * options.sigma_floor_angle.radians());
    equations.information.bottomRightCorner<3, 3>() += turn_weight * fix.rotation_information;
    equations.gradient.tail<3>() += turn_weight * fix.rotation_information * turn;
  }
  if (is_settled) {
    equations.information.block<2, 6>(3, 0).setZero();
    equations.information.block<6, 2>(0, 3).setZero();
    equations.gradient.segment<2>(3).setZero();
  }
  if (is_upright) {
    equations.information.diagonal().segment<2>(3).array() += 1 / (kTiltSigmaRad * kTiltSigmaRad);
  }
  return equations;
}

Rigid3 TurnAbout(const Eigen::Vector3d& pivot_in_map, const Vector6& delta, const Rigid3& pose) {
  const Eigen::Quaterniond turn = RotationFromVector(delta.tail<3>());
  return {turn * pose.rotation(),
          turn * (pose.translation() - pivot_in_map) + pivot_in_map + delta.head<3>()};
}

Eigen::Vector3d Pivot(std::span<const WeightedFix> fixes,
                      std::span<const std::uint32_t> supporters) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0;
  for (const std::uint32_t index : supporters) {
    sum += fixes[index].weight * fixes[index].position_in_map;
    total += fixes[index].weight;
  }
  return sum / total;
}

struct Refined {
  Rigid3 map_from_vo;
  Matrix6 covariance;
};

// Gauss-Newton on the iteratively reweighted cost.
Refined Refine(std::span<const WeightedFix> fixes, std::span<const std::uint32_t> supporters,
               Rigid3 map_from_vo, const AlignmentOptions& options) {
  const Eigen::Vector3d pivot_in_map = Pivot(fixes, supporters);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const NormalEquations equations =
        Linearise(fixes, supporters, map_from_vo, pivot_in_map, Tilt::kSettled, options);
    const Vector6 step = equations.information.ldlt().solve(equations.gradient);
    if (!step.allFinite()) break;
    map_from_vo = TurnAbout(pivot_in_map, step, map_from_vo);
    if (step.norm() < 1e-9) break;
  }
  const NormalEquations equations =
      Linearise(fixes, supporters, map_from_vo, pivot_in_map, Tilt::kDoubted, options);
  const Eigen::LDLT<Matrix6> factor(equations.information);
  Matrix6 covariance = factor.solve(Matrix6::Identity());
  // Fixes that scatter more than they claim make the answer less certain than they claim.
  const auto freedom = static_cast<double>(3 * supporters.size());
  covariance *= std::max(1.0, equations.chi_squared / freedom);
  // What stays upright although fixes lean is off by as much.
  const Vector6 lean = factor.solve(equations.gradient);
  covariance += lean * lean.transpose();
  // What the map itself is off by is in all fixes alike: no number of them averages it away.
  covariance.diagonal().head<3>().array() += options.sigma_floor_m * options.sigma_floor_m;
  // From the pivot to the origin of the odometry frame: t' = t + dt + dr x (t - pivot).
  Matrix6 shift = Matrix6::Identity();
  shift.topRightCorner<3, 3>() = -CrossMatrix(map_from_vo.translation() - pivot_in_map);
  return {map_from_vo, shift * covariance * shift.transpose()};
}

}  // namespace

Eigen::Quaterniond NearestYaw(const Eigen::Quaterniond& rotation) {
  // Maximises the dot product of quaternions over rotations about z.
  Eigen::Quaterniond yaw(rotation.w(), 0, 0, rotation.z());
  if (yaw.norm() < 1e-9) return Eigen::Quaterniond::Identity();  // upside down: any is as near
  return yaw.normalized();
}

Consensus FindConsensus(std::span<const WeightedFix> fixes, const AlignmentOptions& options) {
  CHECK(!fixes.empty());
  const Vote vote(fixes, options);
  Rigid3 map_from_vo = BestHypothesis(fixes, options);
  std::vector<std::uint32_t> supporters = vote.Supporters(map_from_vo);
  if (supporters.empty()) {  // a lone fix that contradicts gravity is still the only guess
    supporters.push_back(static_cast<std::uint32_t>(fixes.size() - 1));
  }
  Refined refined = Refine(fixes, supporters, map_from_vo, options);
  for (int selection = 0; selection < kMaxSelections; ++selection) {
    std::vector<std::uint32_t> next = vote.Supporters(refined.map_from_vo);
    if (next.empty() || next == supporters) break;
    supporters = std::move(next);
    refined = Refine(fixes, supporters, refined.map_from_vo, options);
  }
  double total = 0;
  double supporting = 0;
  for (const WeightedFix& fix : fixes) total += fix.weight;
  for (const std::uint32_t index : supporters) supporting += fixes[index].weight;
  return {refined.map_from_vo, refined.covariance, std::move(supporters), supporting / total};
}

}  // namespace waymark::localiser::internal

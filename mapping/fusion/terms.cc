// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/terms.h"

#include <algorithm>
#include <cmath>

namespace waymark::mapping {
namespace {

/// Written out, as the inner loops need them inlined.
Eigen::Vector3d Apply(const Eigen::Matrix3d& m, const Eigen::Vector3d& v) {
  return m.col(0) * v.x() + m.col(1) * v.y() + m.col(2) * v.z();
}
void AddOuter(const Eigen::Vector3d& a, const Eigen::Vector3d& b, Eigen::Matrix3d& sum) {
  for (int i = 0; i < 3; ++i) sum.col(i) += a * b[i];
}

struct Loss {
  double weight;  ///< its derivative
  double value;
};

/// Both losses by the squared residual in sigmas.
Loss Huber(double square, double limit) {
  if (square <= limit * limit) return {1, square};
  const double residual = std::sqrt(square);
  return {limit / residual, 2 * limit * residual - limit * limit};
}

Loss Evaluate(OverlapLoss loss, double square, double spread) {
  if (loss == OverlapLoss::kHuber) return Huber(square, 1);
  // Cauchy at twice the spread, in units of the spread.
  const double ratio = square / (4 * spread * spread);
  return {1 / (spread * spread * (1 + ratio)), 4 * std::log1p(ratio)};
}

/// Sums over arms a of the first and b of the second submap, from which every block of the
/// equations follows: the derivative of a displacement a - b after (translation, rotation, scale)
/// of the first is [I, -[a]x, a].
struct Moments {
  double weight = 0;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::Zero();
  Eigen::Matrix3d ab = Eigen::Matrix3d::Zero();

  /// The sum of weight * [I, -[a]x, a]^T [I, -[b]x, b].
  Block ToBlock() const {
    Block block;
    block.topLeftCorner<3, 3>() = weight * Eigen::Matrix3d::Identity();
    block.block<3, 3>(0, 3) = -CrossMatrix(b);
    block.block<3, 1>(0, 6) = b;
    block.block<3, 3>(3, 0) = CrossMatrix(a);
    block.block<3, 3>(3, 3) = ab.trace() * Eigen::Matrix3d::Identity() - ab.transpose();
    const Eigen::Vector3d across(ab(1, 2) - ab(2, 1), ab(2, 0) - ab(0, 2), ab(0, 1) - ab(1, 0));
    block.block<3, 1>(3, 6) = across;
    block.block<1, 3>(6, 0) = a.transpose();
    block.block<1, 3>(6, 3) = -across.transpose();
    block(6, 6) = ab.trace();
    return block;
  }
};

}  // namespace

Place Place::FromSim3(const Sim3& map_from_submap, const Eigen::Vector3d& centroid_in_submap) {
  return {map_from_submap.rotation(), map_from_submap * centroid_in_submap,
          std::log(map_from_submap.scale())};
}

Sim3 Place::ToSim3(const Eigen::Vector3d& centroid_in_submap) const {
  const double scale = std::exp(log_scale);
  return {scale, rotation, centroid_in_map - scale * (rotation * centroid_in_submap)};
}

Eigen::Matrix3d Place::MapFromArm() const {
  return std::exp(log_scale) * rotation.toRotationMatrix();
}

void Place::Move(const BlockVector& step) {
  centroid_in_map += step.head<3>();
  rotation = (RotationFromVector(step.segment<3>(3)) * rotation).normalized();
  log_scale += step[6];
}

OrientationShift CompareOrientations(const Eigen::Quaterniond& map_from_first,
                                     const Eigen::Quaterniond& map_from_second,
                                     const Eigen::Quaterniond& second_from_first) {
  const Eigen::Quaterniond shift = map_from_second * second_from_first * map_from_first.conjugate();
  const double sign = shift.w() < 0 ? -1 : 1;
  return {2 * sign * shift.vec(), sign * shift.w()};
}

void Linearise(const OverlapTerm& term, const Place& first, const Place& second, OverlapLoss loss,
               const FusionOptions& options, OverlapEquations& equations) {
  const double per_m2 = 1 / (options.overlap_sigma_m * options.overlap_sigma_m);
  const double per_rad2 = 1 / (options.orientation_sigma_rad * options.orientation_sigma_rad);
  const Eigen::Matrix3d map_from_first = first.MapFromArm();
  const Eigen::Matrix3d map_from_second = second.MapFromArm();
  const Eigen::Vector3d between = first.centroid_in_map - second.centroid_in_map;
  Moments aa, bb, ab;
  BlockVector& on_first = equations.gradient_first.setZero();
  BlockVector& on_second = equations.gradient_second.setZero();
  double turn = 0;
  equations.cost = 0;
  for (const CommonImage& image : term.images) {
    const Eigen::Vector3d a = Apply(map_from_first, image.arm_in_first);
    const Eigen::Vector3d b = Apply(map_from_second, image.arm_in_second);
    const Eigen::Vector3d shift = between + a - b;
    const OrientationShift orientation =
        CompareOrientations(first.rotation, second.rotation, image.second_from_first);
    const double square =
        per_m2 * shift.squaredNorm() + per_rad2 * orientation.shift_rad.squaredNorm();
    const Loss value = Evaluate(loss, square, term.spread);
    equations.cost += value.value / 2;

    const double weight = value.weight * per_m2;
    const Eigen::Vector3d weighted_a = weight * a, weighted_b = weight * b;
    ab.weight += weight;
    ab.a += weighted_a;
    ab.b += weighted_b;
    AddOuter(weighted_a, b, ab.ab);
    AddOuter(weighted_a, a, aa.ab);
    AddOuter(weighted_b, b, bb.ab);
    on_first.head<3>() += weight * shift;
    on_first.segment<3>(3) += weighted_a.cross(shift);
    on_first[6] += weighted_a.dot(shift);
    on_second.segment<3>(3) -= weighted_b.cross(shift);
    on_second[6] -= weighted_b.dot(shift);
    // The derivative of the shift is w to the second, -w to the first, plus what is across it and
    // does not change its length; the matrix takes 1 for w.
    const Eigen::Vector3d pull = (value.weight * per_rad2 * orientation.w) * orientation.shift_rad;
    on_first.segment<3>(3) -= pull;
    on_second.segment<3>(3) += pull;
    turn += value.weight * per_rad2;
  }
  on_second.head<3>() = -on_first.head<3>();
  aa.weight = bb.weight = ab.weight;
  aa.a = aa.b = ab.a;
  bb.a = bb.b = ab.b;
  equations.first = aa.ToBlock();
  equations.second = bb.ToBlock();
  equations.cross = -ab.ToBlock();
  equations.first.diagonal().segment<3>(3).array() += turn;
  equations.second.diagonal().segment<3>(3).array() += turn;
  equations.cross.diagonal().segment<3>(3).array() -= turn;
}

double AddSubmapTerm(const SubmapTerm& term, const Place& place, const FusionOptions& options,
                     Block& matrix, BlockVector& gradient) {
  double cost = 0;
  Moments moments;
  const Eigen::Matrix3d map_from_arm = place.MapFromArm();
  for (const SubmapTerm::Fix& fix : term.fixes) {
    const Eigen::Vector3d arm = Apply(map_from_arm, fix.arm);
    const Eigen::Vector3d shift = place.centroid_in_map + arm - fix.gnss_in_map;
    const double per_m2 = fix.inverse_sigma_m * fix.inverse_sigma_m;
    const Loss value = Huber(per_m2 * shift.squaredNorm(), options.gnss_outlier_sigma);
    cost += term.fix_weight * value.value / 2;
    const double weight = term.fix_weight * value.weight * per_m2;
    const Eigen::Vector3d weighted = weight * arm;
    moments.weight += weight;
    moments.a += weighted;
    AddOuter(weighted, arm, moments.ab);
    gradient.head<3>() += weight * shift;
    gradient.segment<3>(3) += weighted.cross(shift);
    gradient[6] += weighted.dot(shift);
  }
  moments.b = moments.a;
  matrix += moments.ToBlock();
  if (term.gravity_sigma_rad) {
    const double per_rad2 = 1 / (*term.gravity_sigma_rad * *term.gravity_sigma_rad);
    const Eigen::Vector3d z = place.rotation * Eigen::Vector3d::UnitZ();
    cost += per_rad2 * (z - term.up_in_map).squaredNorm() / 2;
    gradient.segment<3>(3) += per_rad2 * term.up_in_map.cross(z);
    matrix.block<3, 3>(3, 3) += per_rad2 * (Eigen::Matrix3d::Identity() - z * z.transpose());
  }
  const double per_scale2 = 1 / (term.scale_sigma * term.scale_sigma);
  const double excess = place.log_scale - term.log_scale;
  cost += per_scale2 * excess * excess / 2;
  gradient[6] += per_scale2 * excess;
  matrix(6, 6) += per_scale2;
  return cost;
}

}  // namespace waymark::mapping

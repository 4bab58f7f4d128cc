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
Eigen::Vector4d Apply(const Eigen::Matrix4d& m, const Eigen::Vector4d& v) {
  return m.col(0) * v[0] + m.col(1) * v[1] + m.col(2) * v[2] + m.col(3) * v[3];
}
/// The lower triangle, where the outcome is symmetric.
void AddLower(const Eigen::Vector3d& a, const Eigen::Vector3d& b, Eigen::Matrix3d& sum) {
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) sum(j, i) += a[j] * b[i];
  }
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

/// What CompareOrientations does to the coefficients of an image's rotation, but for the sign,
/// which neither the length of the vector part nor its product with w depends on.
Eigen::Matrix4d ShiftFromImage(const Eigen::Quaterniond& map_from_first,
                               const Eigen::Quaterniond& map_from_second) {
  Eigen::Matrix4d shift;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Quaterniond unit(Eigen::Vector4d(Eigen::Vector4d::Unit(i)));
    shift.col(i) = (map_from_second * unit * map_from_first.conjugate()).coeffs();
  }
  return shift;
}

/// The loss of the images of an overlap.
class OverlapLosses {
 public:
  OverlapLosses(OverlapLoss loss, double spread)
      : loss_(loss), per_square_(1 / (4 * spread * spread)) {}

  /// Returns the weight of an image, by its squared residual in sigmas.
  double Add(double square) {
    if (loss_ == OverlapLoss::kHuber) {
      const Loss huber = Huber(square, 1);
      sum_ += huber.value;
      return huber.weight;
    }
    // Cauchy at twice the spread, in units of the spread; a logarithm for all images together.
    const double growth = 1 + square * per_square_;
    product_ *= growth;
    if (product_ > kLargest) {
      sum_ += 4 * std::log(product_);
      product_ = 1;
    }
    return 4 * per_square_ / growth;
  }

  double Sum() const { return sum_ + 4 * std::log(product_); }

 private:
  static constexpr double kLargest = 1e100;

  OverlapLoss loss_;
  double per_square_;
  double product_ = 1;
  double sum_ = 0;
};

/// Sums over arms a of the first and b of the second submap, from which every block of the
/// equations follows: the derivative of a displacement a - b after (translation, rotation, scale)
/// of the first is [I, -[a]x, a].
struct Moments {
  double weight = 0;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::Zero();
  Eigen::Matrix3d ab = Eigen::Matrix3d::Zero();

  /// Where only the lower triangle was added up.
  void Mirror() {
    for (int i = 0; i < 3; ++i) {
      for (int j = i + 1; j < 3; ++j) ab(i, j) = ab(j, i);
    }
  }

  /// The sum of weight * a x b.
  Eigen::Vector3d Across() const {
    return {ab(1, 2) - ab(2, 1), ab(2, 0) - ab(0, 2), ab(0, 1) - ab(1, 0)};
  }

  /// The sum of weight * [I, -[a]x, a]^T [I, -[b]x, b].
  Block ToBlock() const {
    Block block;
    block.topLeftCorner<3, 3>() = weight * Eigen::Matrix3d::Identity();
    block.block<3, 3>(0, 3) = -CrossMatrix(b);
    block.block<3, 1>(0, 6) = b;
    block.block<3, 3>(3, 0) = CrossMatrix(a);
    block.block<3, 3>(3, 3) = ab.trace() * Eigen::Matrix3d::Identity() - ab.transpose();
    const Eigen::Vector3d across = Across();
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
  const Eigen::Matrix4d shift_from_image = ShiftFromImage(first.rotation, second.rotation);
  const Eigen::Vector3d between = first.centroid_in_map - second.centroid_in_map;
  Moments aa, bb, ab;
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), pull = Eigen::Vector3d::Zero();
  double turn = 0;
  OverlapLosses losses(loss, term.spread);
  for (const CommonImage& image : term.images) {
    const Eigen::Vector3d a = Apply(map_from_first, image.arm_in_first);
    const Eigen::Vector3d b = Apply(map_from_second, image.arm_in_second);
    const Eigen::Vector3d shift = between + a - b;
    const Eigen::Vector4d rotation = Apply(shift_from_image, image.second_from_first.coeffs());
    const double loss_weight =
        losses.Add(per_m2 * shift.squaredNorm() + 4 * per_rad2 * rotation.head<3>().squaredNorm());
    const double weight = loss_weight * per_m2;
    const Eigen::Vector3d weighted_a = weight * a, weighted_b = weight * b;
    ab.weight += weight;
    ab.a += weighted_a;
    ab.b += weighted_b;
    AddOuter(weighted_a, b, ab.ab);
    AddLower(weighted_a, a, aa.ab);
    AddLower(weighted_b, b, bb.ab);
    force += weight * shift;
    // The derivative of twice the vector part is w to the second, -w to the first, plus what is
    // across it and does not change its length; the matrix takes 1 for w.
    pull += (2 * loss_weight * per_rad2 * rotation.w()) * rotation.head<3>();
    turn += loss_weight * per_rad2;
  }
  equations.cost = losses.Sum() / 2;
  // The sums over (between + a - b), by arms.
  const Eigen::Vector3d across = ab.Across();
  const double dot = ab.ab.trace();
  equations.gradient_first << force, ab.a.cross(between) - across - pull,
      ab.a.dot(between) + aa.ab.trace() - dot;
  equations.gradient_second << -force, across - ab.b.cross(between) + pull,
      bb.ab.trace() - dot - ab.b.dot(between);
  aa.weight = bb.weight = ab.weight;
  aa.a = aa.b = ab.a;
  bb.a = bb.b = ab.b;
  aa.Mirror();
  bb.Mirror();
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
    AddLower(weighted, arm, moments.ab);
    gradient.head<3>() += weight * shift;
    gradient.segment<3>(3) += weighted.cross(shift);
    gradient[6] += weighted.dot(shift);
  }
  moments.b = moments.a;
  moments.Mirror();
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

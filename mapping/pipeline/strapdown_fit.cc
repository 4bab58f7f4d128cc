// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/strapdown_fit.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/base/time.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {
namespace {

using Vector15 = StrapdownFit::Vector;
using Matrix15 = StrapdownFit::Matrix;

constexpr double kGravity = 9.80665;

/// A fix with what was felt until then.
struct Arrival {
  double seconds;  ///< since the beginning
  Eigen::Vector3d felt_displacement;
  Eigen::Matrix<double, 3, 6> displacement_by_bias;
  Eigen::Vector3d position_in_map;
  double sigma_m;
};

std::vector<Arrival> FindArrivals(const Preintegration& felt, std::span<const GnssFix> fixes) {
  std::vector<Arrival> arrivals;
  const std::vector<FeltMotion>& motion = felt.motion;
  for (const GnssFix& fix : fixes) {
    const auto after =
        std::lower_bound(motion.begin(), motion.end(), fix.time,
                         [](const FeltMotion& f, SensorTime t) { return f.time < t; });
    if (after == motion.end() || (after == motion.begin() && after->time > fix.time)) continue;
    const auto before = after == motion.begin() ? after : std::prev(after);
    const double step_s = Seconds(after->time - before->time);
    const double share = step_s > 0 ? Seconds(fix.time - before->time) / step_s : 0;
    arrivals.push_back({Seconds(fix.time - motion.front().time),
                        (1 - share) * before->displacement + share * after->displacement,
                        felt.displacement_by_bias[static_cast<std::size_t>(after - motion.begin())],
                        fix.position_in_map, fix.sigma_m});
  }
  return arrivals;
}

class Solver {
 public:
  Solver(const std::vector<Arrival>& arrivals, const Preintegration::Bias& linearised_at,
         const InertialBiasSigma& sigma)
      : arrivals_(arrivals), linearised_at_(linearised_at) {
    information_.setZero();
    information_.head<3>().setConstant(1 / std::pow(sigma.gyroscope_rad_per_s, 2));
    information_.tail<3>().setConstant(1 / std::pow(sigma.accelerometer_mps2, 2));
  }

  StrapdownFit Solve(StrapdownFit fit) const {
    constexpr int kIterations = 20;
    Matrix15 normal;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      Vector15 gradient;
      Linearise(fit, iteration >= 2, normal, gradient);
      const Vector15 step = normal.ldlt().solve(-gradient);
      if (!step.allFinite()) return StrapdownFit{};
      fit.position += step.head<3>();
      fit.velocity += step.segment<3>(3);
      fit.map_from_sensor =
          (RotationFromVector(step.segment<3>(6)) * fit.map_from_sensor).normalized();
      fit.bias += step.tail<6>();
      if (step.segment<3>(6).norm() < 1e-6 && iteration > 2) break;
    }
    fit.covariance = normal.inverse();
    double squares = 0;
    for (const Arrival& arrival : arrivals_) squares += Residual(fit, arrival).squaredNorm();
    fit.fixes = static_cast<int>(arrivals_.size());
    fit.rms_sigmas = std::sqrt(squares / (3.0 * fit.fixes));
    return fit;
  }

 private:
  Eigen::Vector3d Felt(const StrapdownFit& fit, const Arrival& arrival) const {
    return fit.map_from_sensor *
           (arrival.felt_displacement + arrival.displacement_by_bias * (fit.bias - linearised_at_));
  }

  /// In standard deviations.
  Eigen::Vector3d Residual(const StrapdownFit& fit, const Arrival& arrival) const {
    const double t = arrival.seconds;
    return (fit.position + t * fit.velocity + Felt(fit, arrival) -
            Eigen::Vector3d(0, 0, 0.5 * kGravity * t * t) - arrival.position_in_map) /
           arrival.sigma_m;
  }

  void Linearise(const StrapdownFit& fit, bool is_robust, Matrix15& normal,
                 Vector15& gradient) const {
    constexpr double kHuberSigmas = 2;
    constexpr double kHeadingInformation = 1e-2;
    normal.setZero();
    gradient.setZero();
    normal(8, 8) = kHeadingInformation;
    normal.diagonal().tail<6>() = information_;
    gradient.tail<6>() = information_.cwiseProduct(fit.bias);
    for (const Arrival& arrival : arrivals_) {
      const Eigen::Vector3d residual = Residual(fit, arrival);
      const double weight = is_robust ? 1 / std::max(1.0, residual.norm() / kHuberSigmas) : 1;
      Eigen::Matrix<double, 3, 15> jacobian;
      jacobian << Eigen::Matrix3d::Identity(), arrival.seconds * Eigen::Matrix3d::Identity(),
          -CrossMatrix(Felt(fit, arrival)),
          fit.map_from_sensor.toRotationMatrix() * arrival.displacement_by_bias;
      jacobian /= arrival.sigma_m;
      normal += weight * jacobian.transpose() * jacobian;
      gradient += weight * jacobian.transpose() * residual;
    }
  }

  const std::vector<Arrival>& arrivals_;
  Preintegration::Bias linearised_at_;
  Preintegration::Bias information_;
};

}  // namespace

double StrapdownFit::TiltSigmaRad(const Preintegration& felt, std::size_t sample) const {
  Eigen::Matrix<double, 3, 6> turn;  // by the unknown turn and the gyroscope's bias
  turn << Eigen::Matrix3d::Identity(),
      map_from_sensor.toRotationMatrix() * felt.rotation_by_gyroscope_bias[sample];
  const Eigen::Matrix3d turned = turn * covariance.block<6, 6>(6, 6) * turn.transpose();
  return std::sqrt(std::max(turned(0, 0), turned(1, 1)));
}

StrapdownFit FitStrapdown(const Preintegration& felt, std::span<const GnssFix> fixes,
                          const InertialBiasSigma& bias_sigma) {
  constexpr int kHeadings = 8;
  StrapdownFit best;
  const std::vector<Arrival> arrivals = FindArrivals(felt, fixes);
  if (arrivals.empty()) return best;
  const Solver solver(arrivals, felt.bias, bias_sigma);
  // Over more than a moment, most of what is felt is the answer to gravity.
  const Eigen::Quaterniond level = Eigen::Quaterniond::FromTwoVectors(
      arrivals.back().felt_displacement, Eigen::Vector3d::UnitZ());
  for (int i = 0; i < kHeadings; ++i) {
    StrapdownFit guess;
    guess.map_from_sensor = RotationFromVector({0, 0, 2 * M_PI * i / kHeadings}) * level;
    guess.bias = felt.bias;
    const StrapdownFit fit = solver.Solve(guess);
    if (fit.rms_sigmas < best.rms_sigmas) best = fit;
  }
  return best;
}

}  // namespace waymark::mapping

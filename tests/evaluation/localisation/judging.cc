// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/judging.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

#include "mapping/base/quantile.h"

namespace waymark::evaluation {
namespace {

constexpr double kChiSquare3 = 7.815;   // 95 %
constexpr double kChiSquare6 = 12.592;  // 95 %

template <int kSize>
double NormalisedSquares(const Eigen::Matrix<double, kSize, 1>& error,
                         const Eigen::Matrix<double, kSize, kSize>& covariance) {
  return error.dot(covariance.ldlt().solve(error));
}

double ShareBelow(const std::vector<double>& values, double limit) {
  const auto below =
      std::count_if(values.begin(), values.end(), [&](double value) { return value <= limit; });
  return values.empty() ? 0 : static_cast<double>(below) / static_cast<double>(values.size());
}

}  // namespace

void AddSenses(const PhoneSenses& senses, simulator::Random& random, Question& question) {
  const double direction = random.Uniform(0, 2 * std::numbers::pi);
  const double error_m = random.Uniform(senses.min_gnss_error_m, senses.max_gnss_error_m);
  const Eigen::Vector3d offset(std::cos(direction), std::sin(direction), 0);
  question.request.prior = localiser::PositionPrior{
      Point<Map>(question.map_from_camera.translation() + error_m * offset), senses.prior_radius_m};
  const Eigen::Vector3d tilt = random.NormalVector(senses.gravity_sigma.radians());
  question.request.up_in_camera = question.map_from_camera.rotation().conjugate() *
                                  (RotationFromVector(tilt) * Eigen::Vector3d::UnitZ());
}

Verdict Judge(const Question& question, const localiser::Localisation& answer) {
  Verdict verdict{.kind = question.kind, .reason = answer.reason, .times = answer.times};
  if (!answer.pose) return verdict;
  const Eigen::Matrix<double, 6, 1> error =
      Difference(question.map_from_camera, answer.pose->map_from_camera.rigid());
  const Eigen::Matrix<double, 6, 6>& covariance = answer.pose->covariance;
  verdict.is_accepted = true;
  verdict.inliers = answer.pose->inliers;
  verdict.error_m = error.head<3>().norm();
  verdict.error_deg = Angle::Radians(error.tail<3>().norm()).degrees();
  verdict.position_squares =
      NormalisedSquares<3>(error.head<3>(), covariance.topLeftCorner<3, 3>());
  verdict.rotation_squares =
      NormalisedSquares<3>(error.tail<3>(), covariance.bottomRightCorner<3, 3>());
  verdict.pose_squares = NormalisedSquares<6>(error, covariance);
  return verdict;
}

std::vector<Verdict> AskAll(const localiser::Localiser& localiser,
                            std::span<const Question> questions, const Workshop& workshop) {
  std::vector<Verdict> verdicts(questions.size());
  std::mutex mutex;
  std::size_t done = 0;  // guarded by mutex
  ParallelFor(questions.size(), workshop.parallelism, [&](std::size_t i) {
    verdicts[i] = Judge(questions[i], localiser.Localise(questions[i].request));
    const std::lock_guard lock(mutex);
    if (workshop.progress) workshop.progress("asking", ++done, questions.size());
  });
  return verdicts;
}

Recall Count(std::span<const Verdict> verdicts, const std::string& kind) {
  Recall recall;
  for (const Verdict& verdict : verdicts) {
    if (!kind.empty() && verdict.kind != kind) continue;
    ++recall.requests;
    recall.accepted += verdict.is_accepted;
    recall.within_10cm_1deg += verdict.IsWithin(0.1, 1);
    recall.within_25cm_2deg += verdict.IsWithin(0.25, 2);
    recall.within_1m_5deg += verdict.IsWithin(1, 5);
    recall.false_poses += verdict.IsFalse();
  }
  return recall;
}

double UpperBound95(int events, int trials) {
  if (events >= trials) return 1;
  const auto at_most_events = [&](double rate) {
    double sum = 0;
    for (int k = 0; k <= events; ++k) {
      sum += std::exp(std::lgamma(trials + 1.0) - std::lgamma(k + 1.0) -
                      std::lgamma(trials - k + 1.0) + k * std::log(rate) +
                      (trials - k) * std::log1p(-rate));
    }
    return sum;
  };
  double low = static_cast<double>(events) / trials, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (at_most_events(middle) > 0.05 ? low : high) = middle;
  }
  return high;
}

Calibration Calibrate(std::span<const Verdict> verdicts, const std::string& kind) {
  std::vector<double> position, rotation, pose;
  for (const Verdict& verdict : verdicts) {
    if (!verdict.IsWithin(1, 5) || (!kind.empty() && verdict.kind != kind)) continue;
    position.push_back(verdict.position_squares);
    rotation.push_back(verdict.rotation_squares);
    pose.push_back(verdict.pose_squares);
  }
  return {.poses = static_cast<int>(pose.size()),
          .position_inside = ShareBelow(position, kChiSquare3),
          .rotation_inside = ShareBelow(rotation, kChiSquare3),
          .pose_inside = ShareBelow(pose, kChiSquare6),
          .position_factor = std::sqrt(Quantile(position, 0.95) / kChiSquare3),
          .rotation_factor = std::sqrt(Quantile(rotation, 0.95) / kChiSquare3)};
}

}  // namespace waymark::evaluation

// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/trajectory.h"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "mapping/base/file.h"
#include "mapping/base/median.h"

namespace waymark::evaluation {
namespace {

constexpr double kRotationShare = 0.01;  // lambda, of the spread

using PosePair = std::pair<Rigid3, Rigid3>;  // estimate, truth

std::vector<PosePair> CommonPoses(const Trajectory& estimate, const Trajectory& truth) {
  std::vector<PosePair> pairs;
  for (const auto& [name, pose] : estimate) {
    const auto found = truth.find(name);
    if (found != truth.end()) pairs.emplace_back(pose, found->second);
  }
  return pairs;
}

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign(2) = -1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

Result<Trajectory> LoadTumTrajectory(const std::filesystem::path& path) {
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(path));
  return ParseTumTrajectory(text, path.string());
}

Result<Trajectory> LoadPoseTable(const std::filesystem::path& path) {
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(path));
  std::string tum;
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  if (!line.starts_with("image,status,tx,ty,tz,qx,qy,qz,qw,")) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected a table of poses, found \"{}\"",
                     path.string(), line);
  }
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::string image, status, number;
    std::getline(fields, image, ',');
    std::getline(fields, status, ',');
    if (status != "localised") continue;
    tum += image;
    for (int i = 0; i < 7 && std::getline(fields, number, ','); ++i) tum += ' ' + number;
    tum += '\n';
  }
  return ParseTumTrajectory(tum, path.string());
}

Result<Sim3> EstimateAlignment(const Trajectory& estimate, const Trajectory& truth) {
  const std::vector<PosePair> pairs = CommonPoses(estimate, truth);
  const auto count = static_cast<double>(pairs.size());
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_mean = Eigen::Vector3d::Zero();
  for (const auto& [from, to] : pairs) {
    from_mean += from.translation() / count;
    to_mean += to.translation() / count;
  }
  Eigen::Matrix3d positions = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  double from_spread = 0;
  double to_spread = 0;
  for (const auto& [from, to] : pairs) {
    const Eigen::Vector3d x = from.translation() - from_mean;
    const Eigen::Vector3d y = to.translation() - to_mean;
    positions += y * x.transpose();
    rotations += (to.rotation() * from.rotation().conjugate()).toRotationMatrix();
    from_spread += x.squaredNorm();
    to_spread += y.squaredNorm();
  }
  if (pairs.size() < 2 || !(from_spread > 0) || !(to_spread > 0)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "alignment: expected 2 common images in different places, found {}",
                     pairs.size());
  }
  const double lambda2 = kRotationShare * kRotationShare * to_spread / count;
  double scale = std::sqrt(to_spread / from_spread);
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 10; ++i) {  // each step is a closed form; the two converge at once
    rotation = NearestRotation(scale * positions + lambda2 * rotations);
    scale = (rotation.transpose() * positions).trace() / from_spread;
  }
  if (!(scale > 0)) {
    return MakeError(ErrorCode::kInvalidArgument, "alignment: the paths run against each other");
  }
  return Sim3(scale, Eigen::Quaterniond(rotation), to_mean - scale * (rotation * from_mean));
}

TrajectoryErrors ComputeErrors(const Trajectory& estimate, const Trajectory& truth,
                               const Sim3& truth_from_estimate) {
  const std::vector<PosePair> pairs = CommonPoses(estimate, truth);
  TrajectoryErrors errors;
  errors.common = pairs.size();
  if (pairs.empty()) return errors;
  std::vector<double> distances_m;
  std::vector<double> turns_rad;
  double squares = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Rigid3 aligned = CarryPose(truth_from_estimate, pairs[i].first);
    const Rigid3& exact = pairs[i].second;
    const double distance_m = (aligned.translation() - exact.translation()).norm();
    distances_m.push_back(distance_m);
    turns_rad.push_back(AngleBetween(aligned.rotation(), exact.rotation()).radians());
    errors.mean_m += distance_m / static_cast<double>(pairs.size());
    errors.max_m = std::max(errors.max_m, distance_m);
    squares += distance_m * distance_m;
    if (i > 0) errors.path_m += (exact.translation() - pairs[i - 1].second.translation()).norm();
  }
  errors.rmse_m = std::sqrt(squares / static_cast<double>(pairs.size()));
  errors.median_m = Median(std::move(distances_m));
  errors.median_rotation_rad = Median(std::move(turns_rad));
  return errors;
}

}  // namespace waymark::evaluation

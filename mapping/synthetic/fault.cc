// SPDX-License-Identifier: Apache-2.0
#include "mapping/synthetic/fault.h"

#include <cmath>
#include <functional>
#include <vector>

#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {
namespace {

/// Registered images in the order of time.
struct Way {
  std::vector<std::size_t> images;
  std::vector<Rigid3> poses;
  std::vector<double> along;  ///< share of the way behind each, [0, 1]
};

Way CollectWay(const Reconstruction& reconstruction) {
  Way way;
  double metres = 0;
  for (std::size_t i = 0; i < reconstruction.images.size(); ++i) {
    const auto& pose = reconstruction.images[i].submap_from_camera;
    if (!pose) continue;
    if (!way.poses.empty()) {
      metres += (pose->translation() - way.poses.back().translation()).norm();
    }
    way.images.push_back(i);
    way.poses.emplace_back(pose->rotation(), pose->translation());
    way.along.push_back(metres);
  }
  if (metres > 0) {
    for (double& share : way.along) share /= metres;
  }
  return way;
}

/// Gives the images of the way new poses. Points keep their place, `scales` times as far, before
/// the first image that saw them.
void Move(const Way& way, const std::vector<Rigid3>& poses, const std::vector<double>& scales,
          Reconstruction& reconstruction) {
  std::vector<std::size_t> place(reconstruction.images.size());
  for (std::size_t k = 0; k < way.images.size(); ++k) {
    place[way.images[k]] = k;
    reconstruction.images[way.images[k]].submap_from_camera =
        Transform<Submap, Camera>(poses[k].rotation(), poses[k].translation());
  }
  for (ReconstructedPoint& point : reconstruction.points) {
    if (point.track.empty()) continue;
    const std::size_t k = place[point.track.front().image];
    const Eigen::Vector3d in_camera = way.poses[k].Inverse() * point.position.coordinates();
    point.position = Point<Submap>(poses[k] * (scales[k] * in_camera));
  }
}

/// Walks the way again, with every step turned and stretched.
void Replay(const Way& way, const std::function<Eigen::Quaterniond(double)>& turn_at,
            const std::function<double(double)>& scale_at, Reconstruction& reconstruction) {
  std::vector<Rigid3> poses;
  std::vector<double> scales;
  for (std::size_t k = 0; k < way.poses.size(); ++k) {
    const Rigid3& pose = way.poses[k];
    Eigen::Vector3d position = pose.translation();
    if (k > 0) {
      const double middle = (way.along[k - 1] + way.along[k]) / 2;
      const Eigen::Vector3d step = pose.translation() - way.poses[k - 1].translation();
      position = poses.back().translation() + scale_at(middle) * (turn_at(middle) * step);
    }
    poses.emplace_back(turn_at(way.along[k]) * pose.rotation(), position);
    scales.push_back(scale_at(way.along[k]));
  }
  Move(way, poses, scales, reconstruction);
}

/// Horizontal and unit length, from the first image to the last.
Eigen::Vector3d Ahead(const Way& way) {
  Eigen::Vector3d ahead = way.poses.back().translation() - way.poses.front().translation();
  ahead.z() = 0;
  return ahead.norm() > 0 ? Eigen::Vector3d(ahead.normalized()) : Eigen::Vector3d::UnitY();
}

std::size_t PlaceOf(const Way& way, std::size_t image) {
  std::size_t k = 0;
  while (k < way.images.size() && way.images[k] < image) ++k;
  return k;
}

}  // namespace

void Bend(const BendFault& fault, Reconstruction& reconstruction) {
  const Way way = CollectWay(reconstruction);
  if (way.poses.empty()) return;
  const Eigen::Vector3d ahead = Ahead(way);
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d whole =
      fault.yaw_rad * Eigen::Vector3d::UnitZ() + fault.pitch_rad * right + fault.roll_rad * ahead;
  const auto turn_at = [&](double along) {
    const double share = fault.back ? 1 - std::abs(2 * along - 1) : along;
    return RotationFromVector(share * whole);
  };
  Replay(
      way, turn_at, [](double) { return 1.0; }, reconstruction);
}

void DriftScale(double ratio, Reconstruction& reconstruction) {
  const Way way = CollectWay(reconstruction);
  const auto scale_at = [&](double along) { return std::pow(ratio, along); };
  Replay(
      way, [](double) { return Eigen::Quaterniond::Identity(); }, scale_at, reconstruction);
}

void Fold(std::size_t from, double back_m, Reconstruction& reconstruction) {
  const Way way = CollectWay(reconstruction);
  const std::size_t begin = PlaceOf(way, from);
  if (begin == 0 || begin >= way.poses.size()) return;
  std::size_t earlier = begin;
  double metres = 0;
  while (earlier > 0 && metres < back_m - 1e-6) {
    metres += (way.poses[earlier].translation() - way.poses[earlier - 1].translation()).norm();
    --earlier;
  }
  // The place that image `from` is taken for, `metres` back: everything behind is carried along.
  const Eigen::Vector3d shift =
      (way.poses[earlier].translation() - way.poses[begin].translation()) * (back_m / metres);
  const Eigen::Quaterniond turn =
      way.poses[earlier].rotation() * way.poses[begin].rotation().conjugate();
  std::vector<Rigid3> poses = way.poses;
  const Eigen::Vector3d pivot = way.poses[begin].translation();
  for (std::size_t k = begin; k < poses.size(); ++k) {
    poses[k] =
        Rigid3(turn * poses[k].rotation(), pivot + shift + turn * (poses[k].translation() - pivot));
  }
  Move(way, poses, std::vector<double>(poses.size(), 1), reconstruction);
}

void Hinge(std::size_t from, double yaw_rad, Reconstruction& reconstruction) {
  const Way way = CollectWay(reconstruction);
  const std::size_t begin = PlaceOf(way, from);
  if (begin >= way.poses.size()) return;
  const Eigen::Quaterniond turn = RotationFromVector({0, 0, yaw_rad});
  const Eigen::Vector3d pivot = way.poses[begin].translation();
  std::vector<Rigid3> poses = way.poses;
  for (std::size_t k = begin; k < poses.size(); ++k) {
    poses[k] = Rigid3(turn * poses[k].rotation(), pivot + turn * (poses[k].translation() - pivot));
  }
  Move(way, poses, std::vector<double>(poses.size(), 1), reconstruction);
}

void Mirror(Reconstruction& reconstruction) {
  const Way way = CollectWay(reconstruction);
  if (way.poses.empty()) return;
  const Eigen::Vector3d right = Ahead(way).cross(Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3d reflection = Eigen::Matrix3d::Identity() - 2 * right * right.transpose();
  const Eigen::Vector3d middle = way.poses.front().translation();
  // A reflection on both sides is a rotation again; in the camera it swaps left and right.
  const Eigen::Matrix3d flip = Eigen::Vector3d(-1, 1, 1).asDiagonal();
  for (std::size_t k = 0; k < way.poses.size(); ++k) {
    const Eigen::Matrix3d rotation = reflection * way.poses[k].rotation().toRotationMatrix() * flip;
    reconstruction.images[way.images[k]].submap_from_camera = Transform<Submap, Camera>(
        Eigen::Quaterniond(rotation), middle + reflection * (way.poses[k].translation() - middle));
  }
  for (ReconstructedPoint& point : reconstruction.points) {
    point.position = Point<Submap>(middle + reflection * (point.position.coordinates() - middle));
  }
}

}  // namespace waymark::mapping

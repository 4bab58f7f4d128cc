// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mapping/sfm/reconstruction.h"
#include "mapping/submap/verify.h"

namespace waymark::mapping {

inline CameraModel WalkCamera() {
  return *CameraModel::Create(CameraKind::kSimplePinhole, 640, 480,
                              std::array<double, 3>{500, 320, 240});
}

/// A level drive at 10 m/s with ten images a second, first north, slowly turning left, all
/// registered. The camera looks ahead.
inline Reconstruction MakeWalk(int images, int points = 200) {
  Reconstruction walk;
  walk.cameras = {WalkCamera(), WalkCamera()};
  walk.is_geo_aligned = true;
  walk.mean_reprojection_px = 0.5;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int i = 0; i < images; ++i) {
    const Eigen::Quaterniond level(Eigen::AngleAxisd(0.02 * i, Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitX()));
    walk.images.push_back({.camera = 1,
                           .submap_from_camera = Transform<Submap, Camera>(level, position),
                           .exclusion = ""});
    const double heading = 0.02 * (i + 0.5);
    position += Eigen::Vector3d(-std::sin(heading), std::cos(heading), 0);
  }
  for (int p = 0; p < points; ++p) {
    ReconstructedPoint point;
    point.position = Point<Submap>(p, 50, 2);
    for (int i = 0; i < images; ++i) {
      if ((i + p) % 3 != 0) continue;
      point.track.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(p)});
    }
    walk.points.push_back(std::move(point));
  }
  return walk;
}

inline std::vector<VerificationImage> MeasureWalk(const Reconstruction& walk) {
  std::vector<VerificationImage> images;
  for (std::size_t i = 0; i < walk.images.size(); ++i) {
    const auto& pose = *walk.images[i].submap_from_camera;
    images.push_back(
        {.sequence = "cam0",
         .time = FromNanoseconds<SensorTime>(static_cast<std::int64_t>(i) * 100'000'000),
         .up_in_camera = pose.rotation().conjugate() * Eigen::Vector3d::UnitZ(),
         .gnss_in_submap = Point<Submap>(pose.translation())});
  }
  return images;
}

inline std::vector<MeasuredRotation> MeasureRotations(const Reconstruction& walk) {
  std::vector<MeasuredRotation> rotations;
  for (std::uint32_t i = 0; i + 1 < walk.images.size(); ++i) {
    rotations.push_back({i, i + 1,
                         walk.images[i + 1].submap_from_camera->rotation().conjugate() *
                             walk.images[i].submap_from_camera->rotation(),
                         0.1});
  }
  return rotations;
}

}  // namespace waymark::mapping

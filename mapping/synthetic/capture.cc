// SPDX-License-Identifier: Apache-2.0
#include "mapping/synthetic/capture.h"

#include <algorithm>
#include <unordered_map>

#include "mapping/synthetic/random.h"

namespace waymark::mapping {
namespace {

struct Seen {
  double range_m;
  std::uint32_t point;
  Eigen::Vector2d pixel_px;
};

/// Where a point shows on a sensor whose rows are exposed one after the other: the row it falls on
/// is the one that is exposed just then.
std::optional<Eigen::Vector2d> ProjectRolling(const Eigen::Vector3d& point,
                                              const CameraModel& camera, std::size_t image,
                                              const CaptureOptions& options) {
  constexpr int kIterations = 6;
  double seconds = 0;
  std::optional<Eigen::Vector2d> pixel_px;
  for (int i = 0; i < kIterations; ++i) {
    pixel_px = camera.Project(options.pose_at(image, seconds).Inverse() * point);
    if (!pixel_px) return std::nullopt;
    seconds = options.readout_s * (pixel_px->y() / camera.height_px() - 0.5);
  }
  return pixel_px;
}

std::vector<Seen> VisiblePoints(const World& world, const CameraModel& camera,
                                const Rigid3& world_from_camera, std::size_t image,
                                const CaptureOptions& options) {
  const Rigid3 camera_from_world = world_from_camera.Inverse();
  std::vector<Seen> seen;
  for (std::uint32_t i = 0; i < world.points.size(); ++i) {
    const Eigen::Vector3d towards = world_from_camera.translation() - world.points[i].position;
    const double range_m = towards.norm();
    // Grazing views do not match in real images either.
    if (range_m > options.max_range_m || towards.dot(world.points[i].normal) < 0.1 * range_m) {
      continue;
    }
    const Eigen::Vector3d& point = world.points[i].position;
    const auto pixel_px = options.readout_s != 0 ? ProjectRolling(point, camera, image, options)
                                                 : camera.Project(camera_from_world * point);
    if (pixel_px && camera.Contains(*pixel_px)) seen.push_back({range_m, i, *pixel_px});
  }
  std::stable_sort(seen.begin(), seen.end(),
                   [](const Seen& a, const Seen& b) { return a.range_m < b.range_m; });
  if (seen.size() > static_cast<std::size_t>(options.max_features)) {
    seen.resize(static_cast<std::size_t>(options.max_features));
  }
  return seen;
}

}  // namespace

std::vector<SfmImage> Capture::Images() const {
  std::vector<SfmImage> images;
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    SfmImage image{.camera = 0, .keypoints = keypoints[i]};
    if (gnss_in_world[i]) image.gnss_in_submap = Point<Submap>(*gnss_in_world[i]);
    image.gnss_sigma_m = gnss_sigma_m;
    image.up_in_camera = up_in_camera[i];
    images.push_back(image);
  }
  return images;
}

Capture CaptureWalk(const World& world, const CameraModel& camera, std::span<const Rigid3> walk,
                    const CaptureOptions& options) {
  internal::Random random(options.seed);
  Capture capture{.camera = camera,
                  .world_from_camera = {walk.begin(), walk.end()},
                  .gnss_sigma_m = options.gnss_sigma_m.value_or(1)};
  for (const Rigid3& pose : walk) {
    std::vector<Keypoint> keypoints;
    std::vector<std::uint32_t> point_of;
    for (const Seen& seen : VisiblePoints(world, camera, pose, capture.keypoints.size(), options)) {
      const double x = seen.pixel_px.x() + random.Normal(options.pixel_sigma_px);
      const double y = seen.pixel_px.y() + random.Normal(options.pixel_sigma_px);
      keypoints.push_back({static_cast<float>(x), static_cast<float>(y), 4, 0});
      point_of.push_back(seen.point);
    }
    capture.keypoints.push_back(std::move(keypoints));
    capture.point_of.push_back(std::move(point_of));
    std::optional<Eigen::Vector3d> gnss;
    if (options.gnss_sigma_m) {
      gnss = pose.translation() + random.NormalVector(*options.gnss_sigma_m);
      if (random.Unit() < options.gnss_outlier_share) *gnss += random.NormalVector(40);
    }
    capture.gnss_in_world.push_back(gnss);
    std::optional<Eigen::Vector3d> up;
    if (options.gravity_sigma_rad) {
      up = (pose.rotation().conjugate() * Eigen::Vector3d::UnitZ() +
            random.NormalVector(*options.gravity_sigma_rad))
               .normalized();
    }
    capture.up_in_camera.push_back(up);
  }
  return capture;
}

std::vector<PairMatches> MatchCapture(const Capture& capture, std::size_t min_shared,
                                      const CaptureOptions& options) {
  internal::Random random(options.seed + 1);
  std::vector<PairMatches> pairs;
  for (std::uint32_t i = 0; i < capture.keypoints.size(); ++i) {
    std::unordered_map<std::uint32_t, std::uint32_t> feature_of;
    for (std::uint32_t k = 0; k < capture.point_of[i].size(); ++k) {
      feature_of[capture.point_of[i][k]] = k;
    }
    for (std::uint32_t j = i + 1; j < capture.keypoints.size(); ++j) {
      PairMatches pair{{i, j}, {}};
      for (std::uint32_t k = 0; k < capture.point_of[j].size(); ++k) {
        const auto found = feature_of.find(capture.point_of[j][k]);
        if (found != feature_of.end()) pair.matches.push_back({found->second, k});
      }
      if (pair.matches.size() < min_shared) continue;
      for (FeatureMatch& match : pair.matches) {
        if (random.Unit() >= options.outlier_share) continue;
        match.second = static_cast<std::uint32_t>(random.Below(capture.keypoints[j].size()));
      }
      std::sort(pair.matches.begin(), pair.matches.end());
      pairs.push_back(std::move(pair));
    }
  }
  return pairs;
}

}  // namespace waymark::mapping

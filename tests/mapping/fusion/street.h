// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "mapping/fusion/fusion.h"

namespace waymark::mapping {

/// What the world of a fusion test is like.
struct StreetOptions {
  int submaps = 8;
  int images_per_submap = 50;
  int step = 30;        ///< images between the beginnings of neighbours: 20 are shared
  double bend_rad = 0;  ///< per image, 1 m apart
  double pose_noise_m = 0;
  double pose_noise_rad = 0;
  double gnss_noise_m = 0;
  bool has_gnss = true;
  bool has_gravity = true;
  double tilt_rad = 0;  ///< the submaps' true frames are turned by this about a random axis
  double scale_noise = 0;
  std::uint64_t seed = 1;
};

/// Submaps along a street with the truth known.
struct Street {
  std::vector<FusionSubmap> submaps;
  std::vector<Sim3> map_from_submap;
  std::vector<Rigid3> map_from_camera;  ///< by image number
};

inline Eigen::Vector3d Gaussian3(std::mt19937_64& random, double sigma) {
  std::normal_distribution<double> normal(0, 1);
  return sigma * Eigen::Vector3d(normal(random), normal(random), normal(random));
}

inline std::vector<Rigid3> StreetPoses(int count, double bend_rad) {
  std::vector<Rigid3> poses;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double heading = 0.3;
  for (int i = 0; i < count; ++i) {
    const Eigen::Quaterniond level(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitX()));
    poses.emplace_back(level, position);
    position += Eigen::Vector3d(-std::sin(heading), std::cos(heading), 0);
    heading += bend_rad;
  }
  return poses;
}

inline Street MakeStreet(const StreetOptions& options) {
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal(0, 1);
  Street street;
  street.map_from_camera = StreetPoses(
      (options.submaps - 1) * options.step + options.images_per_submap, options.bend_rad);
  std::vector<Eigen::Vector3d> fixes;
  for (const Rigid3& pose : street.map_from_camera) {
    fixes.push_back(pose.translation() + Gaussian3(random, options.gnss_noise_m));
  }
  for (int s = 0; s < options.submaps; ++s) {
    const int begin = s * options.step;
    const Eigen::Vector3d origin =
        street.map_from_camera[begin + options.images_per_submap / 2].translation();
    const Sim3 truth(std::exp(options.scale_noise * normal(random)),
                     RotationFromVector(Gaussian3(random, options.tilt_rad)),
                     origin + Gaussian3(random, options.tilt_rad * 10));
    FusionSubmap submap;
    submap.map_from_enu = Similarity<Map, Submap>(Sim3(1, Eigen::Quaterniond::Identity(), origin));
    submap.is_geo_aligned = options.has_gnss;
    if (options.has_gravity) submap.gravity_sigma_rad = 0.01;
    for (int i = begin; i < begin + options.images_per_submap; ++i) {
      const Rigid3 pose = CarryPose(truth.Inverse(), street.map_from_camera[i]);
      const Rigid3 noisy(
          RotationFromVector(Gaussian3(random, options.pose_noise_rad)) * pose.rotation(),
          pose.translation() + Gaussian3(random, options.pose_noise_m));
      FusionImage image{.image = static_cast<std::uint64_t>(i),
                        .submap_from_camera = Transform<Submap, Camera>(noisy)};
      if (options.has_gnss) image.gnss_in_map = Point<Map>(fixes[i]);
      submap.images.push_back(std::move(image));
    }
    street.map_from_submap.push_back(truth);
    street.submaps.push_back(std::move(submap));
  }
  return street;
}

/// Errors of the fused map at its images.
struct FusionError {
  double worst_m = 0;
  double worst_rad = 0;
};

inline FusionError MeasureError(const Street& street, const Fusion& fusion,
                                const Sim3& truth_from_fused = Sim3()) {
  FusionError error;
  for (std::size_t s = 0; s < street.submaps.size(); ++s) {
    if (!fusion.submaps[s].map_from_submap) continue;
    const Sim3 place = truth_from_fused * fusion.submaps[s].map_from_submap->sim();
    for (const FusionImage& image : street.submaps[s].images) {
      const Rigid3 pose =
          CarryPose(street.map_from_submap[s].Inverse(), street.map_from_camera[image.image]);
      const Eigen::Vector3d error_in_map =
          place * pose.translation() - street.map_from_camera[image.image].translation();
      error.worst_m = std::max(error.worst_m, error_in_map.norm());
    }
    error.worst_rad =
        std::max(error.worst_rad,
                 AngleBetween(place.rotation(), street.map_from_submap[s].rotation()).radians());
  }
  return error;
}

}  // namespace waymark::mapping

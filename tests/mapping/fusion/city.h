// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "tests/mapping/fusion/street.h"

namespace waymark::mapping {

/// A grid of streets, 150 m from crossing to crossing, each driven twice; a submap every 30 m of
/// each drive. Submaps less than 40 m apart overlap.
struct CityOptions {
  int submaps = 100;
  int shared_images = 20;     ///< per overlap
  double wrong_overlaps = 0;  ///< the share of overlaps that are wrong as a whole, by metres
  double wrong_images = 0;    ///< the share of shared images that are wrong in one of the two
  double pose_noise_m = 0.02;
  double pose_noise_rad = 0.002;
  double gnss_noise_m = 1;
  double tilt_rad = 0.005;
  double scale_noise = 0.005;
  std::uint64_t seed = 1;
};

struct City {
  std::vector<FusionSubmap> submaps;
  std::vector<Sim3> map_from_submap;  ///< the truth
};

/// Centres of the `count` submaps nearest to a corner of the city, so that they are connected.
inline std::vector<Eigen::Vector3d> CityCentres(int count) {
  std::vector<Eigen::Vector3d> centres;
  const int crossings = 2 + static_cast<int>(std::sqrt(count / 10.0));
  for (int drive = 0; drive < 2; ++drive) {
    for (int street = 0; street < crossings; ++street) {
      for (int step = 0; step < 5 * (crossings - 1); ++step) {
        const double along = 15 + 30 * step + 3 * drive, across = 150 * street + drive;
        centres.emplace_back(along, across, 0);
        centres.emplace_back(across, along, 0);
      }
    }
  }
  std::stable_sort(centres.begin(), centres.end(),
                   [](const auto& a, const auto& b) { return a.norm() < b.norm(); });
  centres.resize(std::min(centres.size(), static_cast<std::size_t>(count)));
  return centres;
}

/// Pairs (first < second) of centres less than 40 m apart, through cells of 40 m.
inline std::vector<std::pair<std::size_t, std::size_t>> CityOverlaps(
    const std::vector<Eigen::Vector3d>& centres) {
  const auto cell = [](double x) { return static_cast<int>(std::floor(x / 40)); };
  std::map<std::pair<int, int>, std::vector<std::size_t>> cells;
  std::vector<std::pair<std::size_t, std::size_t>> overlaps;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const int x = cell(centres[i].x()), y = cell(centres[i].y());
    for (int u = x - 1; u <= x + 1; ++u) {
      for (int v = y - 1; v <= y + 1; ++v) {
        const auto found = cells.find({u, v});
        if (found == cells.end()) continue;
        for (const std::size_t j : found->second) {
          if ((centres[i] - centres[j]).norm() < 40) overlaps.emplace_back(j, i);
        }
      }
    }
    cells[{x, y}].push_back(i);
  }
  return overlaps;
}

inline City MakeCity(const CityOptions& options) {
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> uniform(0, 1);
  City city;
  const std::vector<Eigen::Vector3d> centres = CityCentres(options.submaps);
  for (const Eigen::Vector3d& centre : centres) {
    city.map_from_submap.emplace_back(std::exp(options.scale_noise * normal(random)),
                                      RotationFromVector(Gaussian3(random, options.tilt_rad)),
                                      centre + Gaussian3(random, 0.5));
    FusionSubmap submap;
    submap.map_from_enu = Similarity<Map, Submap>(Sim3(1, Eigen::Quaterniond::Identity(), centre));
    submap.gravity_sigma_rad = 0.01;
    city.submaps.push_back(std::move(submap));
  }
  std::uint64_t number = 0;
  for (const auto& [first, second] : CityOverlaps(centres)) {
    const bool is_wrong = uniform(random) < options.wrong_overlaps;
    const Rigid3 wrong(RotationFromVector(Gaussian3(random, 0.2)), Gaussian3(random, 5));
    for (int k = 0; k < options.shared_images; ++k) {
      const double where = (k + 0.5) / options.shared_images;
      const Rigid3 pose(
          RotationFromVector({-M_PI / 2 + 0.1 * normal(random), 0, 2 * M_PI * uniform(random)}),
          centres[first] + where * (centres[second] - centres[first]) +
              Eigen::Vector3d(3 * normal(random), 3 * normal(random), 1.5));
      const Point<Map> fix(pose.translation() + Gaussian3(random, options.gnss_noise_m));
      const bool is_wrong_image = uniform(random) < options.wrong_images;
      const Rigid3 wrong_image(RotationFromVector(Gaussian3(random, 0.5)), Gaussian3(random, 8));
      for (const std::size_t s : {first, second}) {
        Rigid3 seen = CarryPose(city.map_from_submap[s].Inverse(), pose);
        if (s == second && is_wrong) seen = wrong * seen;
        if (s == second && is_wrong_image) seen = wrong_image * seen;
        const Rigid3 noisy(
            RotationFromVector(Gaussian3(random, options.pose_noise_rad)) * seen.rotation(),
            seen.translation() + Gaussian3(random, options.pose_noise_m));
        city.submaps[s].images.push_back({.image = number,
                                          .submap_from_camera = Transform<Submap, Camera>(noisy),
                                          .gnss_in_map = fix,
                                          .gnss_sigma_m = 1});
      }
      ++number;
    }
  }
  return city;
}

/// How far each submap's true centre is from where the fused map has it, root mean square and
/// worst.
inline std::pair<double, double> MeasureCentres(const City& city, const Fusion& fusion) {
  double squares = 0, worst = 0;
  for (std::size_t i = 0; i < city.submaps.size(); ++i) {
    const Eigen::Vector3d centre = city.submaps[i].map_from_enu.sim().translation();
    const Eigen::Vector3d fused =
        fusion.submaps[i].map_from_submap->sim() * (city.map_from_submap[i].Inverse() * centre);
    squares += (fused - centre).squaredNorm();
    worst = std::max(worst, (fused - centre).norm());
  }
  return {std::sqrt(squares / static_cast<double>(city.submaps.size())), worst};
}

}  // namespace waymark::mapping

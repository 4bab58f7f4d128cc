// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/triangulation.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mapping/estimation/projection_derivatives.h"

namespace waymark::mapping {
namespace {

double AngleBetweenRays(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

// The middle of the shortest connection; nullopt when the rays are too parallel or it lies behind.
std::optional<Eigen::Vector3d> Midpoint(const Ray& a, const Ray& b, double min_angle_rad) {
  const double cosine = a.direction.dot(b.direction);
  const double squared_sine = 1 - cosine * cosine;
  const double min_sine = std::sin(min_angle_rad);
  if (!(squared_sine > min_sine * min_sine)) return std::nullopt;
  const Eigen::Vector3d baseline = b.origin - a.origin;
  const double along_a = a.direction.dot(baseline);
  const double along_b = b.direction.dot(baseline);
  const double depth_a = (along_a - cosine * along_b) / squared_sine;
  const double depth_b = (cosine * along_a - along_b) / squared_sine;
  if (!(depth_a > 0) || !(depth_b > 0)) return std::nullopt;
  return 0.5 * (a.origin + depth_a * a.direction + b.origin + depth_b * b.direction);
}

struct Support {
  std::vector<std::uint32_t> inliers;
  double cost = std::numeric_limits<double>::infinity();  // truncated, in squared thresholds
};

Support Evaluate(const Eigen::Vector3d& point_in_world, std::span<const Sighting> sightings,
                 double max_error_px) {
  Support support;
  support.cost = 0;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const double share = ReprojectionErrorPx(point_in_world, sightings[i]) / max_error_px;
    if (share < 1) support.inliers.push_back(static_cast<std::uint32_t>(i));
    support.cost += std::min(share * share, 1.0);
  }
  return support;
}

Eigen::Vector3d Refine(const Eigen::Vector3d& start, std::span<const Sighting> sightings,
                       std::span<const std::uint32_t> chosen) {
  constexpr int kIterations = 4;
  Eigen::Vector3d point = start;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (std::uint32_t i : chosen) {
      const Sighting& sighting = sightings[i];
      const Eigen::Matrix3d camera_from_world =
          sighting.world_from_camera.rotation().conjugate().toRotationMatrix();
      const Eigen::Vector3d x =
          camera_from_world * (point - sighting.world_from_camera.translation());
      if (!(x.z() > 0)) return start;
      const auto projection = ProjectWithDerivatives(
          sighting.camera->kind(), sighting.camera->parameters().data(), x.hnormalized());
      const Eigen::Matrix<double, 2, 3> jacobian =
          projection.by_normalized * NormalizationDerivative(x) * camera_from_world;
      normal.noalias() += jacobian.transpose() * jacobian;
      gradient.noalias() += jacobian.transpose() * (projection.pixel_px - sighting.pixel_px);
    }
    const Eigen::Vector3d step = normal.ldlt().solve(-gradient);
    if (!step.allFinite()) return start;
    point += step;
    if (step.squaredNorm() < 1e-20 * point.squaredNorm()) break;
  }
  return point;
}

// Pairs to try: all of few sightings; of many, each with partners near the far end of the list,
// which for a moving camera have the widest baselines.
template <typename Visit>
void ForEachPair(std::size_t count, const Visit& visit) {
  constexpr std::size_t kAllPairsUpTo = 8;
  if (count <= kAllPairsUpTo) {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = i + 1; j < count; ++j) visit(i, j);
    }
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    visit(i, (i + count / 2) % count);
    visit(i, (i + count / 3) % count);
  }
}

}  // namespace

double ReprojectionErrorPx(const Eigen::Vector3d& point_in_world, const Sighting& sighting) {
  const auto pixel_px =
      sighting.camera->Project(sighting.world_from_camera.rotation().conjugate() *
                               (point_in_world - sighting.world_from_camera.translation()));
  if (!pixel_px) return std::numeric_limits<double>::infinity();
  return (*pixel_px - sighting.pixel_px).norm();
}

double WidestAngle(const Eigen::Vector3d& point_in_world, std::span<const Sighting> sightings,
                   std::span<const std::uint32_t> chosen) {
  double widest = 0;
  for (std::size_t a = 0; a < chosen.size(); ++a) {
    const Eigen::Vector3d from_a =
        sightings[chosen[a]].world_from_camera.translation() - point_in_world;
    for (std::size_t b = a + 1; b < chosen.size(); ++b) {
      const Eigen::Vector3d from_b =
          sightings[chosen[b]].world_from_camera.translation() - point_in_world;
      widest = std::max(widest, AngleBetweenRays(from_a, from_b));
    }
  }
  return widest;
}

std::optional<TriangulatedPoint> Triangulate(std::span<const Sighting> sightings,
                                             const TriangulationOptions& options) {
  std::vector<Ray> rays;
  rays.reserve(sightings.size());
  for (const Sighting& sighting : sightings) {
    rays.push_back(
        {sighting.world_from_camera.translation(),
         sighting.world_from_camera.rotation() * sighting.camera->Unproject(sighting.pixel_px)});
  }
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  Support support;
  ForEachPair(sightings.size(), [&](std::size_t i, std::size_t j) {
    const auto point = Midpoint(rays[i], rays[j], options.min_angle_rad);
    if (!point) return;
    Support candidate = Evaluate(*point, sightings, options.max_error_px);
    if (!(candidate.cost < support.cost)) return;
    best = *point;
    support = std::move(candidate);
  });
  for (int round = 0; round < 2; ++round) {
    if (support.inliers.size() < 2) return std::nullopt;
    best = Refine(best, sightings, support.inliers);
    support = Evaluate(best, sightings, options.max_error_px);
  }
  if (support.inliers.size() < 2 ||
      WidestAngle(best, sightings, support.inliers) < options.min_angle_rad) {
    return std::nullopt;
  }
  return TriangulatedPoint{best, std::move(support.inliers)};
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "mapping/split/internal/cores.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

namespace waymark::mapping {
namespace {

using Positions = std::span<const Eigen::Vector2d>;

Circle EncloseImages(Positions positions, std::span<const std::uint32_t> images) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(images.size());
  for (const std::uint32_t image : images) points.push_back(positions[image]);
  return ComputeEnclosingCircle(points);
}

/// Image indices ordered along the direction in which the positions extend most.
std::vector<std::uint32_t> SweepOrder(Positions positions) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : positions) mean += p / static_cast<double>(positions.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : positions) scatter += (p - mean) * (p - mean).transpose();
  Eigen::Vector2d axis =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(1);
  if (axis.x() < 0 || (axis.x() == 0 && axis.y() < 0)) axis = -axis;

  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return axis.dot(positions[a] - mean) < axis.dot(positions[b] - mean);
  });
  return order;
}

/// The longest beginning of `by_distance` whose smallest circle is within the radius, widened to
/// everything inside that circle.
Core GrowCore(Positions positions, std::span<const std::uint32_t> by_distance, double radius_m) {
  std::size_t fits = 1;  // the seed alone always does
  std::size_t beyond = by_distance.size() + 1;
  while (beyond - fits > 1) {
    const std::size_t middle = fits + (beyond - fits) / 2;
    const bool within = EncloseImages(positions, by_distance.first(middle)).radius <= radius_m;
    (within ? fits : beyond) = middle;
  }
  Core core;
  core.circle = EncloseImages(positions, by_distance.first(fits));
  std::copy_if(by_distance.begin(), by_distance.end(), std::back_inserter(core.images),
               [&](std::uint32_t image) { return core.circle.Contains(positions[image]); });
  std::sort(core.images.begin(), core.images.end());
  return core;
}

/// The images that a core seeded here may take: unowned, near enough, nearest first.
std::vector<std::uint32_t> NearestUnowned(Positions positions, const std::vector<bool>& owned,
                                          std::uint32_t seed, double reach_m) {
  std::vector<std::uint32_t> near;
  const auto distance = [&](std::uint32_t image) {
    return (positions[image] - positions[seed]).squaredNorm();
  };
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    if (!owned[i] && distance(i) <= reach_m * reach_m) near.push_back(i);
  }
  std::stable_sort(near.begin(), near.end(), [&](std::uint32_t a, std::uint32_t b) {
    return distance(a) != distance(b) ? distance(a) < distance(b) : a == seed && b != seed;
  });
  return near;
}

std::size_t CountInside(Positions positions, const Circle& circle) {
  return static_cast<std::size_t>(
      std::count_if(positions.begin(), positions.end(),
                    [&](const Eigen::Vector2d& p) { return circle.Contains(p); }));
}

/// A core of the wanted size, smaller where it would hold too many images, but never below the
/// minimum radius.
Core SeedCore(Positions positions, const std::vector<bool>& owned, std::uint32_t seed,
              const SplitOptions& options) {
  const double smallest_m = options.min_radius_m - options.overlap_m / 2;
  double radius_m = options.radius_m - options.overlap_m / 2;
  const std::vector<std::uint32_t> near = NearestUnowned(positions, owned, seed, 2 * radius_m);
  while (true) {
    Core core = GrowCore(positions, near, radius_m);
    const std::size_t count = CountInside(positions, SubsetCircle(core, options));
    if (radius_m <= smallest_m || count <= static_cast<std::size_t>(options.max_images)) {
      return core;
    }
    radius_m = std::max(smallest_m, 0.9 * radius_m);
  }
}

Core JoinCores(Positions positions, const Core& a, const Core& b) {
  Core joined;
  std::merge(a.images.begin(), a.images.end(), b.images.begin(), b.images.end(),
             std::back_inserter(joined.images));
  joined.circle = EncloseImages(positions, joined.images);
  return joined;
}

struct Joint {
  std::size_t other;
  Core core;
};

/// The neighbour with which the core makes the smallest admissible circle.
std::optional<Joint> FindBestJoint(Positions positions, const std::vector<Core>& cores,
                                   std::size_t small, const SplitOptions& options) {
  std::optional<Joint> best;
  const Core& core = cores[small];
  for (std::size_t i = 0; i < cores.size(); ++i) {
    if (i == small) continue;
    const double apart_m = (cores[i].circle.centre - core.circle.centre).norm();
    if (core.images.size() + cores[i].images.size() >
            static_cast<std::size_t>(options.max_images) ||
        apart_m > 2 * options.max_radius_m) {
      continue;
    }
    Core joined = JoinCores(positions, core, cores[i]);
    if (SubsetCircle(joined, options).radius > options.max_radius_m) continue;
    if (!best || joined.circle.radius < best->core.circle.radius)
      best = Joint{i, std::move(joined)};
  }
  return best;
}

void JoinSmallCores(Positions positions, const SplitOptions& options, std::vector<Core>& cores) {
  std::vector<bool> stays(cores.size(), false);  // small, but nothing admissible is near
  while (true) {
    std::optional<std::size_t> smallest;
    for (std::size_t i = 0; i < cores.size(); ++i) {
      if (stays[i] || cores[i].images.size() >= static_cast<std::size_t>(options.min_images))
        continue;
      if (!smallest || cores[i].images.size() < cores[*smallest].images.size()) smallest = i;
    }
    if (!smallest) return;
    std::optional<Joint> joint = FindBestJoint(positions, cores, *smallest, options);
    if (!joint) {
      stays[*smallest] = true;
      continue;
    }
    cores[joint->other] = std::move(joint->core);
    stays[joint->other] = false;
    cores.erase(cores.begin() + static_cast<std::ptrdiff_t>(*smallest));
    stays.erase(stays.begin() + static_cast<std::ptrdiff_t>(*smallest));
  }
}

}  // namespace

Circle SubsetCircle(const Core& core, const SplitOptions& options) {
  return {core.circle.centre,
          std::max(options.min_radius_m, core.circle.radius + options.overlap_m / 2)};
}

Circle SharingCircle(Positions positions, const Core& core, const SplitOptions& options) {
  Circle circle = SubsetCircle(core, options);
  std::vector<double> distances;  // of images that other cores own
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    if (std::binary_search(core.images.begin(), core.images.end(), i)) continue;
    distances.push_back((positions[i] - circle.centre).norm());
  }
  const std::size_t wanted =
      std::min(static_cast<std::size_t>(options.min_shared_images), distances.size());
  std::partial_sort(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(wanted),
                    distances.end());
  const double limit = std::min(options.max_radius_m, 2 * circle.radius);
  for (std::size_t i = 0; i < wanted && distances[i] <= limit; ++i) {
    circle.radius = std::max(circle.radius, distances[i]);
  }
  return circle;
}

std::vector<Core> SweepCores(Positions positions, const SplitOptions& options) {
  std::vector<Core> cores;
  std::vector<bool> owned(positions.size(), false);
  for (const std::uint32_t seed : SweepOrder(positions)) {
    if (owned[seed]) continue;
    cores.push_back(SeedCore(positions, owned, seed, options));
    for (const std::uint32_t image : cores.back().images) owned[image] = true;
  }
  JoinSmallCores(positions, options, cores);
  return cores;
}

}  // namespace waymark::mapping

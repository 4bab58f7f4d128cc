// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/internal/road.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace waymark::mapping::internal {
namespace {

constexpr double kLaneM = 2;  // a point this far beside the path is on the road driven on
constexpr double kMinHeightM = 0.5, kMaxHeightM = 4;  // of a vehicle's camera
constexpr std::size_t kSections = 8;
constexpr std::size_t kMinKnownSections = 5;
constexpr double kMinKnownSpan = 1.2;  // of `along`, which spans 2
constexpr std::size_t kMinPoints = 8;  // that agree, in a section
constexpr double kMinAgreeing = 0.4;   // of those under the path: others are on cars and kerbs
constexpr double kAgreeing = 0.08;     // relative to the height
constexpr double kRoughness = 0.01;    // of a section: springs, ruts and cambers, relative

/// A point under the path.
struct Beneath {
  double along;
  double log_height;
};

/// Where under the path a point lies, if it does.
std::optional<Beneath> FindBeneath(const Pass& pass, const Eigen::Vector3d& point) {
  double nearest_m = kLaneM;
  std::optional<Beneath> found;
  for (std::size_t k = 1; k < pass.size(); ++k) {
    const PassPlace& a = pass[k - 1];
    const PassPlace& b = pass[k];
    const double length_m = b.along_m - a.along_m;
    const Eigen::Vector2d from_a = point.head<2>() - a.path;
    if (length_m <= 0 || from_a.norm() > nearest_m + length_m) continue;
    const double share = from_a.dot(b.path - a.path) / (length_m * length_m);
    if (share < 0 || share > 1) continue;
    const double beside_m = (from_a - share * (b.path - a.path)).norm();
    const double height_m = a.height_m + share * (b.height_m - a.height_m) - point.z();
    if (beside_m > nearest_m || height_m < kMinHeightM || height_m > kMaxHeightM) continue;
    nearest_m = beside_m;
    found = {Along(pass, a.along_m + share * length_m), std::log(height_m)};
  }
  return found;
}

/// The surface under a part of the path.
struct Section {
  double along;
  double log_height;
  double sigma;
};

/// The height that most points agree on.
std::optional<Section> FindSurface(std::vector<Beneath> points) {
  std::ranges::sort(points, {}, &Beneath::log_height);
  std::size_t begin = 0, size = 0;
  for (std::size_t first = 0, last = 0; last < points.size(); ++last) {
    while (points[last].log_height - points[first].log_height > kAgreeing) ++first;
    if (last - first + 1 > size) std::tie(begin, size) = std::pair(first, last - first + 1);
  }
  if (size < kMinPoints || static_cast<double>(size) < kMinAgreeing * double(points.size())) {
    return std::nullopt;
  }
  Section section{0, 0, 0};
  double squares = 0;
  for (std::size_t k = begin; k < begin + size; ++k) {
    section.along += points[k].along / static_cast<double>(size);
    section.log_height += points[k].log_height / static_cast<double>(size);
  }
  for (std::size_t k = begin; k < begin + size; ++k) {
    squares += std::pow(points[k].log_height - section.log_height, 2);
  }
  const auto count = static_cast<double>(size);
  section.sigma = std::hypot(kRoughness, std::sqrt(squares / (count - 1) / count));
  return section;
}

std::vector<Section> FindSections(const Reconstruction& reconstruction, const Pass& pass) {
  std::array<std::vector<Beneath>, kSections> beneath;
  for (const ReconstructedPoint& point : reconstruction.points) {
    const auto found = FindBeneath(pass, point.position.coordinates());
    if (!found) continue;
    const auto section = static_cast<std::size_t>((found->along + 1) / 2 * kSections);
    beneath[std::min(section, kSections - 1)].push_back(*found);
  }
  std::vector<Section> sections;
  for (std::vector<Beneath>& points : beneath) {
    if (const auto section = FindSurface(std::move(points))) sections.push_back(*section);
  }
  return sections;
}

}  // namespace

std::optional<RoadHeights> MeasureRoadHeights(const Reconstruction& reconstruction,
                                              const Pass& pass) {
  const std::vector<Section> sections = FindSections(reconstruction, pass);
  if (sections.size() < kMinKnownSections ||
      sections.back().along - sections.front().along < kMinKnownSpan) {
    return std::nullopt;
  }
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const auto row = [](const Section& section) {
    return Eigen::Vector3d(section.along, section.along * section.along - 1.0 / 3, 1);
  };
  for (const Section& section : sections) {
    const double weight = 1 / (section.sigma * section.sigma);
    normal += weight * row(section) * row(section).transpose();
    right += weight * section.log_height * row(section);
  }
  const auto solver = normal.ldlt();
  const Eigen::Vector3d fit = solver.solve(right);
  double squares = 0;
  for (const Section& section : sections) {
    squares += std::pow((section.log_height - fit.dot(row(section))) / section.sigma, 2);
  }
  // A road that is rougher than expected tells less.
  const double excess = std::max(1.0, squares / static_cast<double>(sections.size() - 3));
  const Eigen::Matrix3d covariance = excess * solver.solve(Eigen::Matrix3d::Identity());
  return RoadHeights{fit.head<2>(), covariance.topLeftCorner<2, 2>()};
}

}  // namespace waymark::mapping::internal

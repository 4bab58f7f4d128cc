// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/internal/drives_past.h"

#include <algorithm>

#include "mapping/base/median.h"

namespace waymark::mapping::internal {
namespace {

constexpr double kMaxGapS = 5;
constexpr std::size_t kMinImages = 3;
constexpr std::size_t kMinDrives = 3;
constexpr double kMuchNearer = 0.5;

/// By axis. `offset_of` is of one member.
template <typename Members, typename OffsetOf>
Eigen::Vector3d MedianOffset(const Members& members, OffsetOf&& offset_of) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const auto& member : members) values.push_back(offset_of(member)[axis]);
    median[axis] = Median(std::move(values));
  }
  return median;
}

}  // namespace

std::vector<DrivePast> CollectDrivesPast(const Reconstruction& reconstruction,
                                         std::span<const VerificationImage> images) {
  std::vector<std::uint32_t> by_time;
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    if (reconstruction.images[i].submap_from_camera && images[i].gnss_in_submap) {
      by_time.push_back(i);
    }
  }
  std::ranges::stable_sort(by_time, {}, [&](std::uint32_t i) { return images[i].time; });
  std::vector<DrivePast> drives;
  for (auto begin = by_time.begin(), end = begin; begin != by_time.end(); begin = end) {
    for (++end; end != by_time.end(); ++end) {
      if (Seconds(images[*end].time - images[*(end - 1)].time) > kMaxGapS) break;
    }
    DrivePast drive{.images = {begin, end}, .offset_in_submap = {}, .gnss_sigma_m = 0};
    if (drive.images.size() < kMinImages) continue;
    drive.offset_in_submap = MedianOffset(drive.images, [&](std::uint32_t i) -> Eigen::Vector3d {
      return reconstruction.images[i].submap_from_camera->translation() -
             images[i].gnss_in_submap->coordinates();
    });
    std::vector<double> sigmas_m;
    for (const std::uint32_t i : drive.images) sigmas_m.push_back(images[i].gnss_sigma_m);
    drive.gnss_sigma_m = Median(std::move(sigmas_m));
    drives.push_back(std::move(drive));
  }
  return drives;
}

std::vector<DisplacedDrive> FindDisplacedDrives(std::span<const DrivePast> drives,
                                                double min_distance_m, double max_gnss_sigmas) {
  std::vector<DisplacedDrive> displaced;
  if (drives.size() < kMinDrives) return displaced;
  const Eigen::Vector3d common =
      MedianOffset(drives, [](const DrivePast& drive) { return drive.offset_in_submap; });
  const auto distance_m = [&](const DrivePast& drive) {
    return (drive.offset_in_submap - common).norm();
  };
  for (const DrivePast& drive : drives) {
    const double metres = distance_m(drive);
    const auto nearer = std::ranges::count_if(
        drives, [&](const DrivePast& other) { return distance_m(other) < kMuchNearer * metres; });
    if (metres > min_distance_m && metres > max_gnss_sigmas * drive.gnss_sigma_m &&
        2 * static_cast<std::size_t>(nearer) > drives.size()) {
      displaced.push_back({drive.images, metres, metres / drive.gnss_sigma_m});
    }
  }
  return displaced;
}

}  // namespace waymark::mapping::internal

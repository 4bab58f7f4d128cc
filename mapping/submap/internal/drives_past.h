// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/submap/verify.h"

namespace waymark::mapping::internal {

/// Registered images taken while somebody came by once, by whichever camera.
struct DrivePast {
  std::vector<std::uint32_t> images;  ///< that have a GNSS position, by time
  Eigen::Vector3d offset_in_submap;   ///< of their positions from GNSS's: medians
  double gnss_sigma_m;                ///< median
};

/// A drive past that stands where most others of the same place do not.
struct DisplacedDrive {
  std::vector<std::uint32_t> images;
  double metres;  ///< from what is common to all
  double sigmas;
};

/// Drives past with three images or more, by time; those that overlap in time are one.
std::vector<DrivePast> CollectDrivesPast(const Reconstruction& reconstruction,
                                         std::span<const VerificationImage> images);

/// Those whose offset from GNSS no other shares: farther from the common one than
/// `min_distance_m`, than `max_gnss_sigmas`, and than twice as far as most drives are. Pictures
/// whose times are wrong by the same amount are so: on a straight street they turn as the gyroscope
/// says and keep their distances. Of two drives that contradict each other none is named, for
/// nothing tells which is wrong.
std::vector<DisplacedDrive> FindDisplacedDrives(std::span<const DrivePast> drives,
                                                double min_distance_m, double max_gnss_sigmas);

}  // namespace waymark::mapping::internal

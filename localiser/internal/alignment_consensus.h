// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "localiser/odometry_alignment.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::localiser::internal {

/// A fix reduced to what cost (3) needs.
struct WeightedFix {
  Eigen::Vector3d position_in_vo;
  Eigen::Vector3d position_in_map;
  Eigen::Quaterniond map_from_vo_rotation;  ///< as this fix alone sees it
  Eigen::Matrix3d position_information;     ///< inverse covariance with the floor, 1/m^2
  Eigen::Matrix3d rotation_information;     ///< likewise, 1/rad^2
  double weight;                            ///< 2^(-age / half_life), (0, 1]
};

/// The minimiser of cost (3) over the fixes that agree with it.
struct Consensus {
  Rigid3 map_from_vo;
  Eigen::Matrix<double, 6, 6> covariance;
  std::vector<std::uint32_t> supporters;  ///< indices, ascending
  double supporting_share;                ///< of the total weight, [0, 1]
};

/// The rotation about z nearest to a rotation.
Eigen::Quaterniond NearestYaw(const Eigen::Quaterniond& rotation);

/// Finds the alignment that most fixes, by weight, agree upon and refines it over them.
/// Shapes: at least one fix. Deterministic.
Consensus FindConsensus(std::span<const WeightedFix> fixes, const AlignmentOptions& options);

}  // namespace waymark::localiser::internal

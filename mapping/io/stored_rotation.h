// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace waymark::mapping {

/// The quaternion to write for a rotation: one that normalising leaves as it is to the last bit,
/// within a few units in the last place. Reading normalises, so that writing what was read gives
/// the same bytes again; of plain normalised quaternions a third would not.
Eigen::Quaterniond StoredRotation(const Eigen::Quaterniond& rotation);

}  // namespace waymark::mapping

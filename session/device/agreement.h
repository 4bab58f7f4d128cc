// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "session/device/device_session.h"

/// How well phones agree where the same content is, as far as their own poses tell.
namespace waymark::session {

PoseCertainty CertaintyOf(const Eigen::Matrix<double, 6, 6>& covariance);

/// Quantiles of the distance between where two phones show one place.
struct ExpectedDistance {
  double p50_m = 0;
  double p95_m = 0;
};
/// For content `first_m` and `second_m` away from the phones, whose errors are the same on all
/// axes, and independent but for the map's: both stand on it, so that what an alignment allows for
/// it by default (`AlignmentOptions::sigma_floor_m`) is taken off. Phones that see other submaps of
/// a badly joined map are farther from each other than this.
ExpectedDistance ExpectDistance(const PoseCertainty& first, double first_m,
                                const PoseCertainty& second, double second_m);

/// This phone and another look at the same anchor.
struct Agreement {
  AnchorId anchor;
  DeviceId other;
  ExpectedDistance apart;
};

/// Of each anchor with each other phone that is present and shares a pose in the same release of
/// the map, where both are within `reach_m` of it.
std::vector<Agreement> ExpectAgreements(const DevicePose& self, std::span<const OtherDevice> others,
                                        std::span<const SharedAnchor> anchors, double reach_m = 20);

}  // namespace waymark::session

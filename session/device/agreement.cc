// SPDX-License-Identifier: Apache-2.0
#include "session/device/agreement.h"

#include <algorithm>
#include <cmath>

namespace waymark::session {
namespace {

// Of the length of a vector of three independent normal numbers, in their standard deviations.
constexpr double kMedianOfThree = 1.5382;
constexpr double k95OfThree = 2.7955;

double Square(double x) { return x * x; }

// Of a phone's position, what the map is off by.
const double kMapSigma_m = localiser::AlignmentOptions{}.sigma_floor_m;

/// Of what is shown in the map as it is, on an axis: turns move it across the line of sight alone,
/// on two of three.
double VarianceOfShown(const PoseCertainty& certainty, double distance_m) {
  return std::max(0.0, Square(certainty.sigma_m) - Square(kMapSigma_m)) +
         2.0 / 3 * Square(certainty.rotation_sigma_rad * distance_m);
}

double DistanceTo(const Transform<Map, Device>& map_from_device, const SharedAnchor& anchor) {
  return (anchor.map_from_anchor.translation() - map_from_device.translation()).norm();
}

}  // namespace

PoseCertainty CertaintyOf(const Eigen::Matrix<double, 6, 6>& covariance) {
  return {std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3),
          std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3)};
}

ExpectedDistance ExpectDistance(const PoseCertainty& first, double first_m,
                                const PoseCertainty& second, double second_m) {
  const double sigma_m =
      std::sqrt(VarianceOfShown(first, first_m) + VarianceOfShown(second, second_m));
  return {kMedianOfThree * sigma_m, k95OfThree * sigma_m};
}

std::vector<Agreement> ExpectAgreements(const DevicePose& self, std::span<const OtherDevice> others,
                                        std::span<const SharedAnchor> anchors, double reach_m) {
  std::vector<Agreement> agreements;
  if (!self.map_from_device) return agreements;
  const PoseCertainty own = CertaintyOf(self.covariance);
  for (const SharedAnchor& anchor : anchors) {
    const double own_m = DistanceTo(*self.map_from_device, anchor);
    if (own_m > reach_m || anchor.epoch != self.epoch) continue;
    for (const OtherDevice& other : others) {
      if (!other.is_present || !other.map_from_device || other.epoch != self.epoch) continue;
      const double other_m = DistanceTo(*other.map_from_device, anchor);
      if (other_m > reach_m) continue;
      agreements.push_back(
          {anchor.id, other.id, ExpectDistance(own, own_m, other.certainty, other_m)});
    }
  }
  return agreements;
}

}  // namespace waymark::session

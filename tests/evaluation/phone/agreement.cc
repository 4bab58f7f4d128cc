// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/phone/agreement.h"

namespace waymark::evaluation {
namespace {

constexpr double kBetweenLooks_s = 1;
constexpr double kAhead_m = 5;
constexpr double kReach_m = 20;

std::vector<const ShownInstant*> LooksOf(const PhoneTrial& trial) {
  std::vector<const ShownInstant*> looks;
  for (const ShownInstant& instant : trial.shown) {
    if (instant.state != localiser::AlignmentState::kFixed || !instant.shown) continue;
    const bool is_due = looks.empty() || instant.time_s >= looks.back()->time_s + kBetweenLooks_s;
    if (is_due) looks.push_back(&instant);
  }
  return looks;
}

/// Where it is seen in the world by a phone that draws it where it believes it to be.
Eigen::Vector3d ShownInWorld(const ShownInstant& look, const Eigen::Vector3d& anchor_in_map) {
  return look.map_from_device * (look.shown->Inverse() * anchor_in_map);
}

double DistanceTo(const ShownInstant& look, const Eigen::Vector3d& anchor_in_map) {
  return (look.map_from_device.translation() - anchor_in_map).norm();
}

}  // namespace

std::vector<SharedLook> SharedLooks(std::span<const PhoneTrial> trials) {
  std::vector<std::vector<const ShownInstant*>> looks;
  for (const PhoneTrial& trial : trials) looks.push_back(LooksOf(trial));
  std::vector<SharedLook> shared;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    for (std::size_t j = i + 1; j < looks.size(); ++j) {
      for (const ShownInstant* const first : looks[i]) {
        const Eigen::Vector3d anchor = first->map_from_device * Eigen::Vector3d(kAhead_m, 0, 0);
        for (const ShownInstant* const second : looks[j]) {
          const double second_m = DistanceTo(*second, anchor);
          if (second_m > kReach_m) continue;
          shared.push_back(
              {(ShownInWorld(*first, anchor) - ShownInWorld(*second, anchor)).norm(),
               session::ExpectDistance(first->certainty, kAhead_m, second->certainty, second_m)});
        }
      }
    }
  }
  return shared;
}

}  // namespace waymark::evaluation

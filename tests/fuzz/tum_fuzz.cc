// SPDX-License-Identifier: Apache-2.0
// Trajectories of other programs.
#include <cmath>

#include "mapping/base/check.h"
#include "mapping/io/tum_trajectory.h"
#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {

std::vector<Bytes> Seeds() {
  return {
      ToBytes("# timestamp tx ty tz qx qy qz qw\n1.5 0 0 0 0 0 0 1\n\n2 1e3 -2 .5 0.6 0 0 0.8\n"),
      ToBytes("a.jpg 1 2 3 0 1 0 0\r\nb.jpg 1 2 3 0 0 -1 0")};
}

void TryOne(std::span<const std::uint8_t> bytes) {
  const auto poses = mapping::ParseTumTrajectory(ToText(bytes), "fuzz");
  if (!poses) return;
  for (const auto& [name, pose] : *poses) {
    CHECK(!name.empty() && name[0] != '#', "a pose of \"{}\"", name);
    CHECK(pose.translation().allFinite() && std::abs(pose.rotation().norm() - 1) < 2e-3,
          "the pose of {} is none", name);
  }
}

}  // namespace waymark::fuzz

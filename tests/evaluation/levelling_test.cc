// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/levelling.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/base/time.h"
#include "mapping/pipeline/internal/gnss_track.h"
#include "tests/evaluation/simulated_drive.h"

namespace waymark::evaluation {
namespace {

struct Leans {
  int asked = 0;
  std::vector<double> radians;  ///< of what was told, sorted

  double Share(double quantile) const {
    return radians[static_cast<std::size_t>(quantile * static_cast<double>(radians.size() - 1))];
  }
};

Leans LevelDrives(Route route, int drives) {
  Leans leans;
  for (int seed = 0; seed < drives; ++seed) {
    const SimulatedDrive drive = MakeDrive(route, 1000 + static_cast<std::uint64_t>(seed));
    const TangentPlane plane(drive.experience.gnss.front().place);
    const mapping::GnssTrack track(drive.experience.gnss, plane, {});
    const mapping::Levelling levelling(drive.experience.accelerometer, drive.experience.gyroscope,
                                       track.fixes(), {});
    for (double t = 0; t <= drive.duration_s(); t += 0.5) {
      ++leans.asked;
      const auto up = levelling.FindUp(FromNanoseconds<SensorTime>(std::llround(t * 1e9)));
      if (!up) continue;
      const Eigen::Vector3d truth =
          drive.motion.WorldFromBody(t).rotation().conjugate() * Eigen::Vector3d::UnitZ();
      leans.radians.push_back(std::acos(std::min(1.0, up->dot(truth))));
    }
  }
  std::sort(leans.radians.begin(), leans.radians.end());
  return leans;
}

TEST(Levelling, IsTrueOnEveryRouteOrSaysNothing) {
  for (int i = 0; i < kRoutes; ++i) {
    const Leans leans = LevelDrives(static_cast<Route>(i), 20);
    ASSERT_FALSE(leans.radians.empty()) << "route " << i;
    RecordProperty(
        fmt::format("route_{}", i),
        fmt::format("{} of {} told; p50 {:.4f} p95 {:.4f} max {:.4f} rad", leans.radians.size(),
                    leans.asked, leans.Share(0.5), leans.Share(0.95), leans.radians.back()));
    EXPECT_LT(leans.Share(0.5), 0.02) << "route " << i;
    EXPECT_LT(leans.radians.back(), 0.08) << "route " << i;
    EXPECT_GT(leans.radians.size(), 0.7 * leans.asked) << "route " << i;
  }
}

}  // namespace
}  // namespace waymark::evaluation

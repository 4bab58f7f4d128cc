// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/evaluation/simulated_drive.h"

namespace waymark::evaluation {
namespace {

PoseErrors BuildAndCompare(Route route, const Shutter& shutter) {
  const auto built = Build(MakeDrive(route, 7), shutter);
  EXPECT_TRUE(built.ok());
  return built ? CompareWithTruth(*built) : PoseErrors{};
}

TEST(RollingShutter, ModellingItHelpsWhereTheVehicleTurns) {
  constexpr double kReadoutS = 0.03;
  for (const Route route : {Route::kCorner, Route::kStopAndGo}) {
    const PoseErrors global = BuildAndCompare(route, {});
    const PoseErrors ignored = BuildAndCompare(route, {kReadoutS, 0});
    const PoseErrors modelled = BuildAndCompare(route, {kReadoutS, kReadoutS});
    std::printf(
        "p90 of %d, %d, %d images: global %.3f m %.4f rad, rolling ignored %.3f m %.4f rad, "
        "modelled %.3f m %.4f rad\n",
        global.images, ignored.images, modelled.images, global.p90_m, global.p90_rad, ignored.p90_m,
        ignored.p90_rad, modelled.p90_m, modelled.p90_rad);
    const double turning = route == Route::kCorner ? 0.3 : 0.8;  // what is left of the error
    EXPECT_LT(modelled.p90_m, turning * ignored.p90_m);
    EXPECT_EQ(modelled.images, global.images);
  }
}

}  // namespace
}  // namespace waymark::evaluation

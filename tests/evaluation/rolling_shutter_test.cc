// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
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
    const auto figures = [](const PoseErrors& errors) {
      return fmt::format("{} images, p90 {:.3f} m {:.4f} rad", errors.images, errors.p90_m,
                         errors.p90_rad);
    };
    RecordProperty(route == Route::kCorner ? "corner" : "stop_and_go",
                   fmt::format("global shutter {}; rolling, ignored {}; rolling, modelled {}",
                               figures(global), figures(ignored), figures(modelled)));
    const double turning = route == Route::kCorner ? 0.3 : 0.8;  // what is left of the error
    EXPECT_LT(modelled.p90_m, turning * ignored.p90_m);
    EXPECT_EQ(modelled.images, global.images);
  }
}

}  // namespace
}  // namespace waymark::evaluation

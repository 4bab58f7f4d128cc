// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/cell_index.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "mapping/geometry/geodesy.h"
#include "tests/support/random_geometry.h"

namespace waymark::content::internal {
namespace {

GeoPoint Place(double latitude_rad, double longitude_rad) {
  return {.latitude = Angle::Radians(latitude_rad),
          .longitude = Angle::Radians(longitude_rad),
          .ellipsoid_height_m = 0};
}

TEST(CellIndex, ACellIsWithinItsErrorOfEveryPlace) {
  support::RandomGeometry random(1);
  double worst_m = 0;
  for (int i = 0; i < 20'000; ++i) {
    const CellPlace place{std::asin(random.Uniform(-1, 1)), random.Uniform(-M_PI, M_PI)};
    const CellPlace centre = CentreOf(CellOf(place));
    worst_m = std::max(worst_m, GeodesicDistance(Place(place.latitude_rad, place.longitude_rad),
                                                 Place(centre.latitude_rad, centre.longitude_rad)));
  }
  EXPECT_LT(worst_m, kCellError_m);
  EXPECT_GT(worst_m, kCellError_m / 8) << "the bound is far from what is";
}

TEST(CellIndex, ACoveringHoldsEveryPlaceInsideTheCircle) {
  support::RandomGeometry random(2);
  int inside = 0;
  for (int i = 0; i < 4000; ++i) {
    // From a metre to half the earth; every third circle touches a pole or the date line.
    const double radius_m = std::pow(10, random.Uniform(0, 7.3));
    double latitude = std::asin(random.Uniform(-1, 1)), longitude = random.Uniform(-M_PI, M_PI);
    if (i % 6 == 0) latitude = M_PI / 2 - 1e-7 * random.Uniform(0, 1);
    if (i % 6 == 3) longitude = M_PI - 1e-7 * random.Uniform(0, 1);
    const GeoPoint centre = Place(latitude, longitude);
    const Eigen::Vector3d offset = random.Rotation() * Eigen::Vector3d(radius_m, 0, 0);
    const GeoPoint place = TangentPlane(centre).ToGeo(Point<Map>(offset.x(), offset.y(), 0));
    if (GeodesicDistance(centre, place) > radius_m) continue;
    ++inside;
    const std::int64_t cell = CellOf({place.latitude.radians(), place.longitude.radians()});
    const auto ranges = CoverCircle({latitude, longitude}, radius_m);
    EXPECT_TRUE(
        std::any_of(ranges.begin(), ranges.end(),
                    [&](const auto& range) { return range.first <= cell && cell <= range.second; }))
        << radius_m << " m around " << centre.latitude.degrees() << ", "
        << centre.longitude.degrees();
  }
  EXPECT_GT(inside, 1000);
}

TEST(CellIndex, ACoveringOfAHundredMetresIsTight) {
  const auto ranges = CoverCircle({0.83, 0.15}, 100);
  EXPECT_LE(ranges.size(), 8u);
  const std::int64_t far = CellOf({0.83 + 1000.0 / 6.37e6, 0.15});
  EXPECT_TRUE(std::none_of(ranges.begin(), ranges.end(), [&](const auto& range) {
    return range.first <= far && far <= range.second;
  }));
}

TEST(CellIndex, ANumberThatIsNoCellIsSomewhereHarmless) {
  EXPECT_EQ(CentreOf(0).latitude_rad, 0);
  EXPECT_EQ(CentreOf(-1).latitude_rad, 0);
}

}  // namespace
}  // namespace waymark::content::internal

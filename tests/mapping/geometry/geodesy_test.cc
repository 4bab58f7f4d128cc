// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/geodesy.h"

#include <gmock/gmock.h>

#include <limits>
#include <vector>

namespace waymark {
namespace {

GeoPoint Place(double latitude_degrees, double longitude_degrees, double height_m) {
  return {Angle::Degrees(latitude_degrees), Angle::Degrees(longitude_degrees), height_m};
}

TEST(TangentPlane, RoundTripsToAMicrometre) {
  const TangentPlane plane(Place(37.7749, -122.4194, 15));
  const std::vector<Eigen::Vector3d> positions{{0, 0, 0}, {1000, -2000, 30}, {-50, 20, -5}};
  for (const Eigen::Vector3d& x : positions) {
    const GeoPoint place = plane.ToGeo(Point<Map>(x));
    EXPECT_LT((plane.ToMap(place).coordinates() - x).norm(), 1e-6);
  }
}

TEST(TangentPlane, PointsEastNorthUp) {
  const TangentPlane plane(Place(48, 11, 0));
  EXPECT_GT(plane.ToMap(Place(48, 11.001, 0)).coordinates().x(), 70);
  EXPECT_GT(plane.ToMap(Place(48.001, 11, 0)).coordinates().y(), 100);
  EXPECT_NEAR(plane.ToMap(Place(48, 11, 10)).coordinates().z(), 10, 1e-9);
}

TEST(GeodesicDistance, AgreesWithTheTangentPlaneNearby) {
  const GeoPoint a = Place(37.7749, -122.4194, 0), b = Place(37.7752, -122.4190, 0);
  EXPECT_NEAR(GeodesicDistance(a, b), TangentPlane(a).ToMap(b).coordinates().head<2>().norm(),
              1e-3);
}

TEST(GeoPoint, RefusesWhatIsNotOnTheEarth) {
  EXPECT_TRUE(Place(90, 180, 0).Validate());
  EXPECT_FALSE(Place(90.1, 0, 0).Validate());
  EXPECT_FALSE(Place(0, -181, 0).Validate());
  EXPECT_FALSE(Place(0, 0, std::numeric_limits<double>::quiet_NaN()).Validate());
}

}  // namespace
}  // namespace waymark

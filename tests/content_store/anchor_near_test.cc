// SPDX-License-Identifier: Apache-2.0
// What every anchor store promises about neighbours.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/content_store/anchor_stores.h"

namespace waymark::content {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_P(AnchorNeighbours, NeighboursComeNearestFirst) {
  const GeoPoint centre = PlaceAt(47.37, 8.54);
  const TangentPlane plane(centre);
  for (std::uint64_t n = 1; n <= 5; ++n) {
    AnchorRecord record = MakeAnchor(n);
    record.place = plane.ToGeo(Point<Map>(0, 20.0 * static_cast<double>(6 - n), 5));
    Applied(store_->Create(record));
  }
  AnchorRecord elsewhere = MakeAnchor(6, "other");
  elsewhere.place = centre;
  Applied(store_->Create(elsewhere));
  EXPECT_THAT(Near(centre, 61), ElementsAre(IdOf(5).text(), IdOf(4).text(), IdOf(3).text()));
  EXPECT_THAT(Near(centre, 1000, 2), ElementsAre(IdOf(5).text(), IdOf(4).text()));
  EXPECT_THAT(Near(centre, 10), IsEmpty());
  EXPECT_THAT(Near(centre, 1000, 0), IsEmpty());
  EXPECT_EQ(Near(centre, 3e7).size(), 5u) << "a circle around the earth";
}

TEST_P(AnchorNeighbours, AreThoseOfAnExhaustiveSearch) {
  support::RandomGeometry random(23);
  const GeoPoint centre = PlaceAt(61.2, -149.9);
  const TangentPlane plane(centre);
  std::vector<std::pair<double, std::string>> all;
  for (std::uint64_t n = 0; n < 120; ++n) {
    AnchorRecord record = MakeAnchor(n);
    const double reach_m = std::pow(10, random.Uniform(-1, 4));  // crowded in the middle
    record.place = plane.ToGeo(Point<Map>(random.Rotation() * Eigen::Vector3d(reach_m, 0, 0)));
    Applied(store_->Create(record));
    all.emplace_back(GeodesicDistance(centre, record.place), record.id.text());
  }
  std::sort(all.begin(), all.end());
  for (const std::size_t limit : {1, 2, 5, 20, 60, 120}) {
    std::vector<std::string> expected;
    for (std::size_t i = 0; i < limit; ++i) expected.push_back(all[i].second);
    EXPECT_EQ(Near(centre, 20'000, limit), expected);
    const double radius_m = all[limit - 1].first;
    EXPECT_EQ(Near(centre, radius_m, 1000), expected) << "the rim belongs to the circle";
  }
}

TEST_P(AnchorNeighbours, EquallyNearOnesAreOrderedById) {
  for (const std::uint64_t n : {4, 2, 3, 1}) {
    AnchorRecord record = MakeAnchor(n);
    record.place = PlaceAt(10, 10);
    Applied(store_->Create(record));
  }
  EXPECT_THAT(Near(PlaceAt(10, 10), 0),
              ElementsAre(IdOf(1).text(), IdOf(2).text(), IdOf(3).text(), IdOf(4).text()));
  EXPECT_THAT(Near(PlaceAt(10, 10), 1, 2), ElementsAre(IdOf(1).text(), IdOf(2).text()));
}

TEST_P(AnchorNeighbours, NeighboursAreFoundAcrossTheDateLineAndAtThePoles) {
  AnchorRecord east = MakeAnchor(1), west = MakeAnchor(2), north = MakeAnchor(3);
  east.place = PlaceAt(-17, 179.9999);
  west.place = PlaceAt(-17, -179.9999);
  north.place = PlaceAt(90, 12);
  for (const auto& record : {east, west, north}) Applied(store_->Create(record));
  EXPECT_THAT(Near(PlaceAt(-17, 180), 20),
              testing::UnorderedElementsAre(IdOf(1).text(), IdOf(2).text()));
  EXPECT_THAT(Near(PlaceAt(89.9999, -170), 20), ElementsAre(IdOf(3).text()));
}

TEST_P(AnchorNeighbours, AnUpdateMovesAnAnchorInSpace) {
  AnchorRecord record = Applied(store_->Create(MakeAnchor(1)));
  const GeoPoint before = record.place;
  record.place = PlaceAt(-33.9, 151.2);
  Applied(store_->Update(record, record.revision));
  EXPECT_THAT(Near(before, 100), IsEmpty());
  EXPECT_THAT(Near(record.place, 1), ElementsAre(record.id.text()));
}

TEST_P(AnchorNeighbours, ImpossibleQueriesAreRefused) {
  EXPECT_THAT(Near(PlaceAt(91, 0), 10), ElementsAre(HasSubstr("latitude")));
  for (const double radius_m : {-1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THAT(Near(PlaceAt(0, 0), radius_m), ElementsAre(HasSubstr("radius")));
  }
}

}  // namespace
}  // namespace waymark::content

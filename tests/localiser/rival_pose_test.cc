// SPDX-License-Identifier: Apache-2.0
// A place that stands twice in the map has a second pose that explains what the first one does.
#include "localiser/internal/rival_pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "tests/localiser/random_place.h"

namespace waymark::localiser::internal {
namespace {

using Copy = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// What a viewpoint sees, each feature beside its landmark and, every `each`th, beside a copy.
std::vector<SeenResemblance> See(const RandomPlace& place, const Rigid3& viewpoint,
                                 std::size_t each, const Copy& copy) {
  std::vector<SeenResemblance> seen;
  std::uint32_t feature = 0;
  for (const Eigen::Vector3d& landmark : place.landmarks()) {
    const auto pixel_px = TestCamera().Project(viewpoint.Inverse() * landmark);
    if (!pixel_px || !TestCamera().Contains(*pixel_px)) continue;
    seen.push_back({feature, 0, *pixel_px, landmark});
    if (feature % each == 0) seen.push_back({feature, 0, *pixel_px, copy(landmark)});
    ++feature;
  }
  return seen;
}

Copy MovedBy(const Eigen::Vector3d& offset) {
  return [=](const Eigen::Vector3d& landmark) { return Eigen::Vector3d(landmark + offset); };
}

class RivalPose : public testing::Test {
 protected:
  Rivalry Find(std::size_t each, const Copy& copy, double same_place_m = 1) const {
    return FindRival(Placed(), See(place_, viewpoint_, each, copy),
                     {.max_error_px = 6, .same_place_m = same_place_m});
  }

  std::vector<PlacedImage> Placed() const { return {{TestCamera(), viewpoint_}}; }

  RandomPlace place_{1};
  Rigid3 viewpoint_ = place_.Viewpoint(1, 0.5);
};

TEST_F(RivalPose, IsTheOneBeforeTheCopy) {
  const Rivalry rivalry = Find(1, MovedBy({21, 2, 0}));
  EXPECT_GT(rivalry.supporters, 100U);
  EXPECT_EQ(rivalry.rivals, rivalry.supporters);
  const Eigen::Vector3d moved = rivalry.map_from_camera.translation() - viewpoint_.translation();
  EXPECT_LT((moved - Eigen::Vector3d(21, 2, 0)).norm(), 0.05);
}

TEST_F(RivalPose, IsFoundAcrossTheStreetToo) {
  const Rivalry rivalry = Find(1, [](const Eigen::Vector3d& landmark) {
    return Eigen::Vector3d(40 - landmark.x(), -landmark.y(), landmark.z());
  });
  EXPECT_EQ(rivalry.rivals, rivalry.supporters);
  EXPECT_NEAR(AngleBetween(rivalry.map_from_camera.rotation(), viewpoint_.rotation()).degrees(),
              180, 0.5);
}

TEST_F(RivalPose, HasAsManySupportersAsTheCopyHasFeatures) {
  const Rivalry rivalry = Find(4, MovedBy({21, 0, 0}));
  EXPECT_NEAR(static_cast<double>(rivalry.rivals), 0.25 * static_cast<double>(rivalry.supporters),
              3);
  EXPECT_NEAR(rivalry.Share(), 0.25, 0.08);
}

TEST_F(RivalPose, HasNearlyNoneWhereResemblancesAreChance) {
  support::RandomGeometry random(3);
  const Rivalry rivalry = Find(1, [&](const Eigen::Vector3d&) {
    return Eigen::Vector3d(random.Uniform(-40, 40), random.Uniform(10, 16), random.Uniform(-1, 7));
  });
  EXPECT_LT(static_cast<double>(rivalry.rivals), 0.1 * static_cast<double>(rivalry.supporters));
}

TEST_F(RivalPose, OfManyResemblancesByChanceHasNoMoreThanChance) {
  support::RandomGeometry random(3);
  std::vector<SeenResemblance> seen = See(place_, viewpoint_, 1, MovedBy({500, 0, 0}));
  const std::size_t own = seen.size();
  for (std::size_t i = 0; i < own; ++i) {
    for (int other = 0; other < 100; ++other) {
      seen.push_back({seen[i].feature,
                      0,
                      seen[i].pixel_px,
                      {random.Uniform(-40, 40), random.Uniform(10, 16), random.Uniform(-1, 7)}});
    }
  }
  std::ranges::stable_sort(seen, {}, &SeenResemblance::feature);
  const Rivalry rivalry = FindRival(Placed(), seen, {});
  EXPECT_GT(static_cast<double>(rivalry.rivals), 0.09 * static_cast<double>(rivalry.supporters));
  EXPECT_LT(rivalry.Share(), 0.05);
}

TEST_F(RivalPose, IsNotSoughtInTheSamePlace) {
  EXPECT_EQ(Find(1, MovedBy({0.8, 0, 0})).rivals, 0U);
  EXPECT_GT(Find(1, MovedBy({0.8, 0, 0}), 0.5).rivals, 100U);
}

TEST_F(RivalPose, IsTheSameEachTime) {
  const Rivalry once = Find(2, MovedBy({21, 0, 0})), again = Find(2, MovedBy({21, 0, 0}));
  EXPECT_EQ(once.rivals, again.rivals);
  EXPECT_EQ(once.map_from_camera.translation(), again.map_from_camera.translation());
}

TEST_F(RivalPose, NeedsNoResemblance) {
  const Rivalry rivalry = FindRival(Placed(), {}, {});
  EXPECT_EQ(rivalry.supporters, 0U);
  EXPECT_EQ(rivalry.rivals, 0U);
}

}  // namespace
}  // namespace waymark::localiser::internal

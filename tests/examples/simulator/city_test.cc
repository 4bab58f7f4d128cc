// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/city.h"

#include <gmock/gmock.h>

#include <set>

#include "examples/simulator/world/facade_plan.h"
#include "examples/simulator/world/street.h"
#include "tests/examples/simulator/small_world.h"

namespace waymark::simulator {
namespace {

CityOptions TinyCity(std::uint64_t seed) {
  CityOptions options = QuickSimulation().city;
  options.texels_per_m = 12;
  options.seed = seed;
  return options;
}

Radiance Picture(const City& city) {
  const Renderer renderer = *Renderer::Create(city, {}, MakeLighting(LightPreset::kDay, Random(1)));
  const ViewRays rays(*MakeCamera({.width_px = 64, .height_px = 48}));
  return renderer.Render(rays, {BodyFromCameraRotation(Angle::Degrees(20), Angle::Degrees(5)),
                                Eigen::Vector3d(2, -5, 1.7)});
}

TEST(City, IsTheSameForTheSameSeedOnAnyNumberOfThreads) {
  CityOptions options = TinyCity(3);
  options.parallelism.threads = 1;
  const Radiance one = Picture(*BuildCity(options));
  options.parallelism.threads = 4;
  EXPECT_EQ(one.values, Picture(*BuildCity(options)).values);
  EXPECT_NE(one.values, Picture(*BuildCity(TinyCity(4))).values);
}

TEST(City, GivesEveryHouseAPictureOfItsOwn) {
  const City city = *BuildCity(TinyCity(3));
  std::set<std::uint32_t> used;
  for (const Quad& quad : city.mesh.quads()) used.insert(quad.material.texture);
  EXPECT_GT(used.size(), 15U);
  EXPECT_LT(*used.rbegin(), city.textures.size());
}

TEST(City, RepeatsItsHousesWhenAskedTo) {
  const BuildingLine line{{0, 0}, {1, 0}, 60};
  const std::vector<House> own = PlanRow(line, Random(1), 0, Random(9));
  EXPECT_NE(own[0].seed, own[1].seed);
  const std::vector<House> repeated = PlanRow(line, Random(1), 2, Random(9));
  EXPECT_NE(repeated[0].seed, repeated[1].seed);
  EXPECT_EQ(repeated[0].seed, repeated[2].seed);
  EXPECT_EQ(repeated[0].plan.width_m, repeated[2].plan.width_m);
  EXPECT_EQ(PlanRow(line, Random(2), 2, Random(9))[1].seed, repeated[1].seed);
}

TEST(City, IsClosedToEverySide) {
  const City city = *BuildCity(TinyCity(3));
  const Renderer renderer = *Renderer::Create(city, {}, EvenLight());
  for (int degree = 0; degree < 360; degree += 3) {
    const double angle = Angle::Degrees(degree).radians();
    EXPECT_TRUE(renderer.FindSurface({-7, -7, 1.5}, {std::cos(angle), std::sin(angle), 0.05}))
        << degree;
    EXPECT_TRUE(renderer.FindSurface({-7, -7, 1.5}, {std::cos(angle), std::sin(angle), -0.2}))
        << degree;
  }
}

TEST(City, GrowsWithItsBlocks) {
  CityOptions options = TinyCity(3);
  options.blocks_east = 2;
  const StreetPlan plan = PlanStreets(options);
  EXPECT_EQ(plan.blocks.size(), 2U);
  EXPECT_EQ(plan.crossings.size(), 6U);
  EXPECT_EQ(plan.segments.size(), 7U);
  EXPECT_EQ(plan.building_lines.size(), 12U);
}

TEST(City, RefusesSizesOutOfRange) {
  CityOptions options;
  options.road_m = 1;
  const auto city = BuildCity(options);
  ASSERT_FALSE(city.ok());
  EXPECT_THAT(city.error().message, testing::HasSubstr("road_m"));
}

TEST(FacadePlan, OpeningsAreDisjointAndInsideTheFront) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const double width = random.Uniform(6, 13);
    const double height = random.Uniform(8.5, 15.5);
    const FacadePlan plan = PlanFacade(width, height, random);
    double floor = 0;
    for (const Storey& storey : plan.storeys) {
      EXPECT_NEAR(storey.floor_m, floor, 1e-9);
      EXPECT_LT(storey.floor_m, storey.sill_m);
      EXPECT_LT(storey.sill_m + 0.5, storey.head_m);
      EXPECT_LT(storey.head_m, storey.ceiling_m);
      floor = storey.ceiling_m;
      double done = 0;
      for (const Opening& opening : storey.openings) {
        EXPECT_LT(done, opening.left_m);
        EXPECT_LT(opening.left_m, opening.right_m);
        done = opening.right_m;
      }
      EXPECT_LT(done, width);
    }
    EXPECT_LE(floor, height);
  }
}

TEST(Traffic, LeavesTheMiddleOfTheRoadFree) {
  const City city = *BuildCity(TinyCity(3));
  const Mesh traffic = MakeTraffic(city, {.parked_share = 1, .people_per_100_m = 40}, Random(1));
  EXPECT_GT(traffic.quads().size(), 100U);
  for (const StreetSegment& segment : PlanStreets(city.options).segments) {
    for (const Quad& quad : traffic.quads()) {
      const Eigen::Vector2d offset = quad.top_left.head<2>() - segment.start;
      const double along = offset.dot(segment.direction);
      if (along < 0 || along > segment.length_m) continue;
      EXPECT_GT(std::abs(offset.x() * segment.direction.y() - offset.y() * segment.direction.x()),
                1.8);
    }
  }
}

}  // namespace
}  // namespace waymark::simulator

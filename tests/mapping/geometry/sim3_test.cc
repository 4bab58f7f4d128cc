// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/sim3.h"

#include <gmock/gmock.h>

#include <vector>

#include "tests/support/random_geometry.h"

namespace waymark {
namespace {

using support::Near;
using support::RandomGeometry;

TEST(Sim3, ObeysTheLawsOfAGroup) {
  RandomGeometry random(1);
  for (int i = 0; i < 200; ++i) {
    const Sim3 a = random.Similarity(), b = random.Similarity(), c = random.Similarity();
    EXPECT_THAT(a * a.Inverse(), Near(Sim3()));
    EXPECT_THAT((a * b) * c, Near(a * (b * c)));
    EXPECT_NEAR((a * b).scale(), a.scale() * b.scale(), 1e-12);
    const Eigen::Vector3d x = random.Vector(10);
    EXPECT_LT(((a * b) * x - a * (b * x)).norm(), 1e-10);
  }
}

TEST(Sim3, CarryingAPoseMovesItsCentreAndTurnsItsAxes) {
  RandomGeometry random(2);
  const Sim3 map_from_submap = random.Similarity();
  const Rigid3 submap_from_camera = random.Rigid();
  const Rigid3 map_from_camera = CarryPose(map_from_submap, submap_from_camera);
  EXPECT_LT(
      (map_from_camera.translation() - map_from_submap * submap_from_camera.translation()).norm(),
      1e-12);
  EXPECT_THAT(CarryPose(map_from_submap.Inverse(), map_from_camera), Near(submap_from_camera));
}

TEST(EstimateSimilarity, RecoversTheTransform) {
  RandomGeometry random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const Sim3 truth = random.Similarity();
    std::vector<Eigen::Vector3d> from, to;
    for (int i = 0; i < 10; ++i) {
      from.push_back(random.Vector(5));
      to.push_back(truth * from.back());
    }
    const auto estimate = EstimateSimilarity(from, to);
    ASSERT_TRUE(estimate);
    EXPECT_THAT(*estimate, Near(truth));
    EXPECT_NEAR(estimate->scale(), truth.scale(), 1e-9);
  }
}

TEST(EstimateSimilarity, NeverReflects) {
  const std::vector<Eigen::Vector3d> from{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<Eigen::Vector3d> mirrored{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  EXPECT_GT(EstimateSimilarity(from, mirrored).value().rotation().toRotationMatrix().determinant(),
            0);
}

TEST(EstimateSimilarity, RefusesPointsOnALine) {
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_FALSE(EstimateSimilarity(line, line));
  EXPECT_FALSE(EstimateSimilarity(std::span(line).first(2), std::span(line).first(2)));
}

}  // namespace
}  // namespace waymark

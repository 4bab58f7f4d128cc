// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/geo_alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace waymark::mapping {
namespace {

/// A drive down a straight street, reconstructed in a frame of its own, with fixes and verticals.
struct StraightDrive {
  Sim3 model_from_enu;
  std::vector<GeoSample> samples;

  explicit StraightDrive(unsigned seed, double weave_m) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1);
    const auto noise = [&](double sigma) {
      return Eigen::Vector3d(sigma * normal(random), sigma * normal(random),
                             sigma * normal(random));
    };
    model_from_enu = Sim3(0.3, RotationFromVector(noise(1)), noise(5));
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector3d place(3.0 * i, weave_m * std::sin(0.4 * i), 1.6);
      const Rigid3 enu_from_camera(RotationFromVector({-M_PI / 2, 0, 0}), place);
      const Eigen::Vector3d up = enu_from_camera.rotation().conjugate() * Eigen::Vector3d::UnitZ();
      samples.push_back({.model_from_camera = CarryPose(model_from_enu, enu_from_camera),
                         .position_in_enu = place + noise(0.3),
                         .position_sigma_m = 1,
                         .up_in_camera = (up + noise(0.01)).normalized()});
    }
  }

  double LeanOf(const GeoAlignment& alignment) const {
    const Eigen::Vector3d up = alignment.enu_from_model.rotation() *
                               (model_from_enu.rotation() * Eigen::Vector3d::UnitZ());
    return std::atan2(up.head<2>().norm(), up.z());
  }
};

TEST(GeoAlignment, DoesNotRollAboutAStraightStreet) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const StraightDrive drive(seed, 0.2);
    const auto alignment = EstimateGeoAlignment(drive.samples, {.seed = seed});
    ASSERT_TRUE(alignment.has_value()) << seed;
    EXPECT_LT(drive.LeanOf(*alignment), 0.03) << seed;
    EXPECT_GE(alignment->inliers.size(), 28u) << seed;
    EXPECT_NEAR(alignment->enu_from_model.scale() * 0.3, 1, 0.02) << seed;
  }
}

TEST(GeoAlignment, VerticalsThatLieAreOutvotedByTheOthers) {
  StraightDrive drive(5, 0.2);
  for (std::size_t i = 0; i < drive.samples.size(); i += 4) {
    drive.samples[i].up_in_camera = Eigen::Vector3d(1, 0, 0);
  }
  const auto alignment = EstimateGeoAlignment(drive.samples, {});
  ASSERT_TRUE(alignment.has_value());
  EXPECT_LT(drive.LeanOf(*alignment), 0.03);
}

TEST(GeoAlignment, PositionsTooCloseTogetherSayNothing) {
  StraightDrive drive(5, 0);
  for (GeoSample& sample : drive.samples) sample.position_sigma_m = 500;
  EXPECT_FALSE(EstimateGeoAlignment(drive.samples, {}).has_value());
  drive.samples.resize(2);
  EXPECT_FALSE(EstimateGeoAlignment(drive.samples, {}).has_value());
}

}  // namespace
}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/fusion.h"

#include <gtest/gtest.h>

#include "tests/mapping/fusion/city.h"
#include "tests/mapping/fusion/street.h"

namespace waymark::mapping {
namespace {

Fusion Fuse(const Street& street, const FusionOptions& options = {}) {
  auto fusion = FuseSubmaps(street.submaps, options);
  EXPECT_TRUE(fusion.ok()) << (fusion.ok() ? "" : fusion.error().message);
  return fusion.ok() ? *fusion : Fusion{};
}

TEST(Fusion, ExactDataIsPlacedExactly) {
  const Street street = MakeStreet({.bend_rad = 0.01, .tilt_rad = 0.02, .scale_noise = 0.01});
  Street free = street;
  for (FusionSubmap& submap : free.submaps) submap.gravity_sigma_rad.reset();
  const Fusion fusion = Fuse(free, {.scale_sigma = 100});
  EXPECT_TRUE(fusion.converged);
  EXPECT_TRUE(fusion.is_geo_referenced);
  const FusionError error = MeasureError(street, fusion);
  EXPECT_LT(error.worst_m, 1e-3);
  EXPECT_LT(error.worst_rad, 1e-4);
  EXPECT_LT(fusion.submaps[0].overlap_rms_m, 1e-3);
  EXPECT_EQ(fusion.submaps[0].shared_images, 20);
  EXPECT_EQ(fusion.submaps[1].shared_images, 40);
  EXPECT_EQ(fusion.submaps[1].disagreeing_images, 0);
}

TEST(Fusion, NoisyStreetIsBetterThanItsGnss) {
  const Street street = MakeStreet({.submaps = 12,
                                    .bend_rad = 0.005,
                                    .pose_noise_m = 0.02,
                                    .pose_noise_rad = 0.002,
                                    .gnss_noise_m = 1.5,
                                    .tilt_rad = 0.005,
                                    .scale_noise = 0.005});
  const Fusion fusion = Fuse(street);
  EXPECT_LT(MeasureError(street, fusion).worst_m, 1.0);
  for (const FusedSubmap& submap : fusion.submaps) {
    EXPECT_LT(submap.overlap_rms_m, 0.1);
    EXPECT_NEAR(submap.gnss_rms_m, 1.5 * std::sqrt(3), 0.8);
    EXPECT_EQ(submap.gnss_images, 50);
  }
}

TEST(Fusion, StraightStreetDoesNotRollAboutItself) {
  // Positions on a line say nothing about roll; gravity and shared orientations do.
  const Street street = MakeStreet(
      {.pose_noise_m = 0.02, .pose_noise_rad = 0.002, .gnss_noise_m = 1, .tilt_rad = 0.01});
  EXPECT_LT(MeasureError(street, Fuse(street)).worst_rad, 0.02);
}

TEST(Fusion, OneLevelSubmapLevelsItsNeighbours) {
  Street street = MakeStreet({.submaps = 4, .pose_noise_rad = 0.001, .gnss_noise_m = 0.5});
  const Eigen::Quaterniond roll(
      Eigen::AngleAxisd(0.2, Eigen::Vector3d(-std::sin(0.3), std::cos(0.3), 0)));
  for (int s = 1; s < 4; ++s) {  // built rolled about the street
    street.submaps[s].gravity_sigma_rad.reset();
    for (FusionImage& image : street.submaps[s].images) {
      image.submap_from_camera = Transform<Submap, Camera>(
          Rigid3(roll.conjugate(), Eigen::Vector3d::Zero()) * image.submap_from_camera.rigid());
    }
    street.map_from_submap[s] = street.map_from_submap[s] * Sim3(1, roll, Eigen::Vector3d::Zero());
  }
  EXPECT_LT(MeasureError(street, Fuse(street)).worst_rad, 0.02);
}

TEST(Fusion, EqualInputGivesEqualBytesOnAnyNumberOfThreads) {
  const City city = MakeCity({.submaps = 200, .wrong_overlaps = 0.1});
  const Fusion one = *FuseSubmaps(city.submaps, {.parallelism = {.threads = 1}});
  for (const int threads : {1, 3}) {
    const Fusion again = *FuseSubmaps(city.submaps, {.parallelism = {.threads = threads}});
    for (std::size_t s = 0; s < city.submaps.size(); ++s) {
      const Sim3& a = one.submaps[s].map_from_submap->sim();
      const Sim3& b = again.submaps[s].map_from_submap->sim();
      EXPECT_EQ(a.translation(), b.translation());
      EXPECT_EQ(a.rotation().coeffs(), b.rotation().coeffs());
      EXPECT_EQ(a.scale(), b.scale());
    }
  }
}

TEST(Fusion, AScaleThatIsWellKnownIsKept) {
  // The fixes lie: their street is 4 % longer than the submap's own metre says.
  Street street = MakeStreet({.submaps = 1});
  const Eigen::Vector3d centre = street.map_from_submap[0].translation();
  for (FusionImage& image : street.submaps[0].images) {
    const Eigen::Vector3d fix = image.gnss_in_map->coordinates();
    image.gnss_in_map = Point<Map>(Eigen::Vector3d(centre + 1.04 * (fix - centre)));
  }
  const auto fuse = [&](std::optional<double> scale_sigma) {
    street.submaps[0].scale_sigma = scale_sigma;
    return Fuse(street).submaps[0].map_from_submap->sim().scale();
  };
  EXPECT_GT(fuse(std::nullopt), 1.02) << "the options' 5 % yield to the fixes";
  EXPECT_EQ(fuse(0.05), fuse(std::nullopt));
  EXPECT_NEAR(fuse(0.0005), 1, 0.001);
}

TEST(Fusion, WithoutGnssTheFirstSubmapIsHeld) {
  const Street street = MakeStreet({.bend_rad = 0.01,
                                    .pose_noise_m = 0.002,
                                    .pose_noise_rad = 0.0005,
                                    .has_gnss = false,
                                    .has_gravity = false,
                                    .tilt_rad = 1.0,
                                    .scale_noise = 0.5});
  const Fusion fusion = Fuse(street);
  EXPECT_FALSE(fusion.is_geo_referenced);
  ASSERT_TRUE(fusion.submaps[0].map_from_submap.has_value());
  const Sim3& held = fusion.submaps[0].map_from_submap->sim();
  EXPECT_NEAR((held.translation() - street.submaps[0].map_from_enu.sim().translation()).norm(), 0,
              1e-9);
  const Sim3 truth_from_fused = street.map_from_submap[0] * held.Inverse();
  const FusionError error = MeasureError(street, fusion, truth_from_fused);
  EXPECT_LT(error.worst_m, 1.5) << "drift over 260 m";
  EXPECT_LT(error.worst_rad, 0.02);
}

TEST(Fusion, UnalignedSubmapJoinsThroughItsOverlaps) {
  Street street = MakeStreet(
      {.bend_rad = 0.01, .pose_noise_m = 0.01, .pose_noise_rad = 0.001, .gnss_noise_m = 0.3});
  const Sim3 gauge(3.0, RotationFromVector({1, 2, 0.5}), {10, 20, 30});
  FusionSubmap& loose = street.submaps[4];
  loose.is_geo_aligned = false;
  loose.gravity_sigma_rad.reset();
  for (FusionImage& image : loose.images) {
    image.gnss_in_map.reset();
    image.submap_from_camera =
        Transform<Submap, Camera>(CarryPose(gauge, image.submap_from_camera.rigid()));
  }
  street.map_from_submap[4] = street.map_from_submap[4] * gauge.Inverse();
  EXPECT_LT(MeasureError(street, Fuse(street)).worst_m, 0.4);
}

TEST(Fusion, UnalignedSubmapWithoutOverlapIsNotPlaced) {
  Street street = MakeStreet({.submaps = 3, .step = 60});
  street.submaps[1].is_geo_aligned = false;
  for (FusionImage& image : street.submaps[1].images) image.gnss_in_map.reset();
  const Fusion fusion = Fuse(street);
  EXPECT_TRUE(fusion.submaps[0].map_from_submap);
  EXPECT_FALSE(fusion.submaps[1].map_from_submap);
  EXPECT_TRUE(fusion.submaps[2].map_from_submap);
}

TEST(Fusion, ScaleDriftIsTakenOut) {
  const Street street = MakeStreet({.submaps = 20,
                                    .bend_rad = 0.01,
                                    .pose_noise_m = 0.01,
                                    .pose_noise_rad = 0.001,
                                    .gnss_noise_m = 1,
                                    .scale_noise = 0.03});
  const Fusion fusion = Fuse(street);
  EXPECT_LT(MeasureError(street, fusion).worst_m, 0.8);
  for (std::size_t s = 0; s < street.submaps.size(); ++s) {
    EXPECT_NEAR(fusion.submaps[s].map_from_submap->sim().scale(), street.map_from_submap[s].scale(),
                0.015);
  }
}

TEST(Fusion, ALocalChangeLeavesDistantSubmapsAndReportsDisplacement) {
  Street street =
      MakeStreet({.submaps = 30, .pose_noise_m = 0.02, .pose_noise_rad = 0.002, .gnss_noise_m = 1});
  const Fusion before = Fuse(street);
  for (std::size_t s = 0; s < street.submaps.size(); ++s) {
    street.submaps[s].previous = before.submaps[s].map_from_submap;
  }
  const Fusion same = Fuse(street);
  for (const FusedSubmap& submap : same.submaps) EXPECT_LT(submap.moved_m, 1e-3);
  for (FusionImage& image : street.submaps[29].images) {
    image.gnss_in_map = Point<Map>(image.gnss_in_map->coordinates() + Eigen::Vector3d(0, 0, 1.5));
  }
  const Fusion after = Fuse(street);
  EXPECT_GT(after.submaps[29].moved_m, 0.3);
  EXPECT_LT(after.submaps[0].moved_m, 2e-3);
}

TEST(Fusion, TwoThousandSubmapsConverge) {
  const Street street = MakeStreet({.submaps = 2000,
                                    .bend_rad = 0.0003,
                                    .pose_noise_m = 0.02,
                                    .pose_noise_rad = 0.002,
                                    .gnss_noise_m = 1.5,
                                    .tilt_rad = 0.005,
                                    .scale_noise = 0.01});
  const Fusion fusion = Fuse(street);
  EXPECT_TRUE(fusion.converged);
  EXPECT_LT(MeasureError(street, fusion).worst_m, 1.5);
}

TEST(Fusion, RefusesWrongInput) {
  Street street = MakeStreet({.submaps = 2});
  EXPECT_FALSE(FuseSubmaps(street.submaps, {.overlap_sigma_m = 0}).ok());
  street.submaps[1].images.push_back(street.submaps[1].images.front());
  EXPECT_EQ(FuseSubmaps(street.submaps, {}).error().code, ErrorCode::kInvalidArgument);
  street.submaps[1].images.clear();
  EXPECT_FALSE(FuseSubmaps(street.submaps, {}).ok());
  EXPECT_TRUE(FuseSubmaps({}, {})->submaps.empty());
  street = MakeStreet({.submaps = 2});
  street.submaps[1].scale_sigma = 0;
  EXPECT_EQ(FuseSubmaps(street.submaps, {}).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace waymark::mapping

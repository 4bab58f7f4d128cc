// SPDX-License-Identifier: Apache-2.0
// Wrong images, overlaps and fixes do not pull the map.
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/mapping/fusion/city.h"
#include "tests/mapping/fusion/street.h"

namespace waymark::mapping {
namespace {

std::pair<double, double> Errors(const CityOptions& options) {
  const City city = MakeCity(options);
  return MeasureCentres(city, *FuseSubmaps(city.submaps, {}));
}

TEST(RobustFusion, WrongOverlapsDoNotPull) {
  const StreetOptions options{
      .bend_rad = 0.01, .pose_noise_m = 0.02, .pose_noise_rad = 0.002, .gnss_noise_m = 0.5};
  Street street = MakeStreet(options);
  std::mt19937_64 random(5);
  std::uniform_int_distribution<int> coin(0, 9);
  int spoiled = 0;
  for (int s = 1; s < 8; s += 2) {
    for (int i = 0; i < 20; ++i) {
      if (coin(random) >= 3) continue;  // 30 % of the shared images are registered wrongly
      Rigid3 wrong(RotationFromVector(Gaussian3(random, 0.5)), Gaussian3(random, 8));
      FusionImage& image = street.submaps[s].images[i];
      image.submap_from_camera =
          Transform<Submap, Camera>(wrong * image.submap_from_camera.rigid());
      ++spoiled;
    }
  }
  const Fusion fusion = *FuseSubmaps(street.submaps, {});
  EXPECT_LT(MeasureError(street, fusion).worst_m, 0.5);
  int disagreeing = 0;
  for (const FusedSubmap& submap : fusion.submaps) {
    disagreeing += submap.disagreeing_images;
    EXPECT_LT(submap.overlap_rms_m, 0.1);
  }
  EXPECT_EQ(disagreeing, 2 * spoiled);
}

TEST(RobustFusion, AThirdOfWrongImagesDoesNotPull) {
  // What error there is comes from their fixes, which are true and so at wrong places.
  const auto [rms_m, worst_m] = Errors({.submaps = 60, .wrong_images = 0.3, .gnss_noise_m = 0.5});
  EXPECT_LT(rms_m, 0.3);
  EXPECT_LT(worst_m, 0.5);
}

TEST(RobustFusion, ATenthOfWrongOverlapsDoesNotPull) {
  CityOptions options{.submaps = 100, .wrong_overlaps = 0.1, .gnss_noise_m = 0.5};
  const auto [rms_m, worst_m] = Errors(options);
  EXPECT_LT(rms_m, 0.1);
  EXPECT_LT(worst_m, 0.4);
}

/// Two submaps share what looks like one house and is two.
TEST(RobustFusion, AWhollyWrongOverlapIsLetGoOf) {
  City city = MakeCity({.submaps = 60, .gnss_noise_m = 0.5});
  const Fusion before = *FuseSubmaps(city.submaps, {});
  const Rigid3 where(RotationFromVector({0, 0, 0.4}), {6, -4, 0});
  for (std::uint64_t k = 0; k < 20; ++k) {
    for (const std::size_t s : {std::size_t{5}, std::size_t{50}}) {
      const Rigid3 pose(RotationFromVector({-1.5, 0, 0.1}), {double(k), 2, 1});
      city.submaps[s].images.push_back(
          {.image = 1'000'000 + k, .submap_from_camera = Transform<Submap, Camera>(where * pose)});
    }
  }
  const Fusion after = *FuseSubmaps(city.submaps, {});
  for (const std::size_t s : {std::size_t{5}, std::size_t{50}}) {
    EXPECT_EQ(after.submaps[s].disagreeing_images, before.submaps[s].disagreeing_images + 20);
  }
  for (std::size_t s = 0; s < city.submaps.size(); ++s) {
    EXPECT_LT((after.submaps[s].map_from_submap->sim().translation() -
               before.submaps[s].map_from_submap->sim().translation())
                  .norm(),
              0.01);
  }
}

/// Images that a submap shares with one neighbour are seen from it elsewhere.
void SpoilOverlap(std::size_t submap, std::size_t neighbour, const Rigid3& wrong, City& city) {
  std::set<std::uint64_t> shared;
  for (const FusionImage& image : city.submaps[neighbour].images) shared.insert(image.image);
  for (FusionImage& image : city.submaps[submap].images) {
    if (!shared.contains(image.image)) continue;
    image.submap_from_camera = Transform<Submap, Camera>(wrong * image.submap_from_camera.rigid());
  }
}

/// Two wrong overlaps pull it to where neither they nor the three right ones are satisfied.
TEST(RobustFusion, ASubmapBetweenRightAndWrongOverlapsFindsTheRightOnes) {
  const CityOptions options{.submaps = 80, .gnss_noise_m = 0.5};
  const City right = MakeCity(options);
  std::vector<std::vector<std::size_t>> neighbours(right.submaps.size());
  for (const auto& [a, b] : CityOverlaps(CityCentres(options.submaps))) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  std::mt19937_64 random(2);
  int tried = 0;
  for (std::size_t s = 0; s < right.submaps.size() && tried < 12; ++s) {
    if (neighbours[s].size() != 5) continue;
    City city = right;
    const Rigid3 wrong(RotationFromVector(Gaussian3(random, 0.2)), Gaussian3(random, 6));
    SpoilOverlap(s, neighbours[s][0], wrong, city);
    SpoilOverlap(s, neighbours[s][1],
                 Rigid3(wrong.rotation(), wrong.translation() + Gaussian3(random, 1)), city);
    EXPECT_LT(MeasureCentres(city, *FuseSubmaps(city.submaps, {})).second, 0.5) << "submap " << s;
    ++tried;
  }
  EXPECT_EQ(tried, 12);
}

TEST(RobustFusion, GnssOutliersDoNotPull) {
  Street street = MakeStreet({.pose_noise_m = 0.02, .pose_noise_rad = 0.002, .gnss_noise_m = 0.5});
  for (FusionSubmap& submap : street.submaps) {
    for (FusionImage& image : submap.images) {
      if (image.image >= 100 && image.image < 115) {  // under a bridge
        image.gnss_in_map =
            Point<Map>(image.gnss_in_map->coordinates() + Eigen::Vector3d(40, 10, 0));
      }
    }
  }
  EXPECT_LT(MeasureError(street, *FuseSubmaps(street.submaps, {})).worst_m, 1.0);
}

}  // namespace
}  // namespace waymark::mapping

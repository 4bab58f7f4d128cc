// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "mapping/fusion/fusion.h"
#include "tests/mapping/fusion/city.h"

namespace waymark::mapping {
namespace {

/// Fixes that count fully hold the map in place: a change reaches less far, and a small city does.
const FusionOptions kOptions{.gnss_weight = 1};

Fusion Fuse(const std::vector<FusionSubmap>& submaps) { return *FuseSubmaps(submaps, kOptions); }
Fusion Update(const std::vector<FusionSubmap>& submaps) { return *UpdateFusion(submaps, kOptions); }

std::size_t CountHeld(const Fusion& fusion) {
  return static_cast<std::size_t>(
      std::ranges::count_if(fusion.submaps, [](const auto& submap) { return submap.is_held; }));
}

void SetPrevious(const Fusion& fusion, std::vector<FusionSubmap>& submaps) {
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    submaps[i].previous = fusion.submaps[i].map_from_submap;
  }
}

/// The greatest distance between the two at any camera.
double Difference(const std::vector<FusionSubmap>& submaps, const Fusion& a, const Fusion& b) {
  double greatest_m = 0;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    for (const FusionImage& image : submaps[i].images) {
      const Eigen::Vector3d& x = image.submap_from_camera.rigid().translation();
      greatest_m = std::max(greatest_m, (a.submaps[i].map_from_submap->sim() * x -
                                         b.submaps[i].map_from_submap->sim() * x)
                                            .norm());
    }
  }
  return greatest_m;
}

bool IsSame(const Similarity<Map, Submap>& a, const Similarity<Map, Submap>& b) {
  return a.sim().scale() == b.sim().scale() && a.sim().translation() == b.sim().translation() &&
         a.sim().rotation().coeffs() == b.sim().rotation().coeffs();
}

TEST(UpdateFusion, WithoutAChangeNothingMoves) {
  City city = MakeCity({.submaps = 100, .wrong_overlaps = 0.1});
  SetPrevious(Fuse(city.submaps), city.submaps);
  const Fusion update = Update(city.submaps);
  EXPECT_TRUE(update.converged);
  EXPECT_EQ(CountHeld(update), city.submaps.size());
  for (std::size_t i = 0; i < city.submaps.size(); ++i) {
    EXPECT_TRUE(IsSame(*update.submaps[i].map_from_submap, *city.submaps[i].previous));
    EXPECT_GT(update.submaps[i].shared_images, 0) << "evidence is there for those held, too";
  }
}

TEST(UpdateFusion, WithoutPreviousPlacesIsAWholeFusion) {
  const City city = MakeCity({.submaps = 30});
  EXPECT_EQ(Difference(city.submaps, Update(city.submaps), Fuse(city.submaps)), 0);
  EXPECT_TRUE(UpdateFusion({}, {})->submaps.empty());
  EXPECT_FALSE(UpdateFusion(city.submaps, {.held_motion_m = 0}).ok());
}

/// Additions and removals one after the other, each upon the update before it, so that errors
/// would add up.
TEST(UpdateFusion, FollowsAdditionsAndRemovalsAsAWholeFusionWould) {
  std::mt19937_64 random(11);
  for (const double wrong_overlaps : {0.0, 0.1}) {
    const City city = MakeCity({.submaps = 400, .wrong_overlaps = wrong_overlaps});
    std::vector<FusionSubmap> present(city.submaps.begin(), city.submaps.end() - 4);
    std::vector<FusionSubmap> absent(city.submaps.end() - 4, city.submaps.end());
    SetPrevious(Fuse(present), present);
    std::size_t held = 0;
    for (int change = 0; change < 8; ++change) {
      if (change % 2 == 0) {
        const auto removed =
            present.begin() + static_cast<std::ptrdiff_t>(random() % present.size());
        absent.push_back(*removed);
        absent.back().previous.reset();
        present.erase(removed);
      } else {
        std::swap(absent[random() % absent.size()], absent.back());
        present.push_back(std::move(absent.back()));
        absent.pop_back();
      }
      const Fusion update = Update(present);
      EXPECT_TRUE(update.converged);
      EXPECT_LT(Difference(present, update, Fuse(present)), 1e-3)
          << "change " << change << ", held " << CountHeld(update);
      held += CountHeld(update);
      for (std::size_t i = 0; i < present.size(); ++i) {
        if (!update.submaps[i].is_held) continue;
        EXPECT_TRUE(IsSame(*update.submaps[i].map_from_submap, *present[i].previous));
      }
      SetPrevious(update, present);
    }
    EXPECT_GT(held, 8 * 100u) << "most changes are small";
  }
}

TEST(UpdateFusion, FindsThatFixesChanged) {
  City city = MakeCity({.submaps = 400});
  SetPrevious(Fuse(city.submaps), city.submaps);
  for (FusionImage& image : city.submaps[200].images) {
    image.gnss_in_map =
        Point<Map>(Eigen::Vector3d(image.gnss_in_map->coordinates() + Eigen::Vector3d(0, 0, 0.02)));
  }
  const Fusion update = Update(city.submaps);
  EXPECT_GT(update.submaps[200].moved_m, 5e-4);
  EXPECT_GT(CountHeld(update), 200u);
  EXPECT_LT(Difference(city.submaps, update, Fuse(city.submaps)), 1e-3);
}

/// A street that comes back to where it began, without GNSS: all hangs together, and has drifted.
TEST(UpdateFusion, ClosingALongLoopMovesTheWholeMap) {
  Street street = MakeStreet({.submaps = 40,
                              .bend_rad = 2 * M_PI / 1200,
                              .pose_noise_m = 0.02,
                              .pose_noise_rad = 0.002,
                              .has_gnss = false,
                              .has_gravity = false});
  SetPrevious(Fuse(street.submaps), street.submaps);
  FusionSubmap closing;
  closing.is_geo_aligned = false;
  for (const int begin : {0, 1200}) {
    for (int i = begin; i < begin + 20; ++i) {
      closing.images.push_back({.image = static_cast<std::uint64_t>(i),
                                .submap_from_camera = Transform<Submap, Camera>(
                                    street.map_from_camera[static_cast<std::size_t>(i)])});
    }
  }
  street.submaps.push_back(std::move(closing));
  const Fusion update = Update(street.submaps);
  EXPECT_EQ(CountHeld(update), 0u);
  EXPECT_GT(update.submaps[20].moved_m, 0.1);
  EXPECT_EQ(Difference(street.submaps, update, Fuse(street.submaps)), 0);
}

}  // namespace
}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/prune.h"

#include <gmock/gmock.h>

#include <array>

#include "tests/mapping/submap/walk.h"

namespace waymark::mapping {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

struct Walk {
  Reconstruction found = MakeWalk(40);
  std::vector<VerificationImage> images = MeasureWalk(found);
  std::vector<MeasuredRotation> rotations = MeasureRotations(found);

  std::vector<ImplausibleImage> Find() const {
    return *FindImplausibleImages(found, images, rotations, {});
  }
  void Move(std::size_t image, const Eigen::Vector3d& by, const Eigen::Vector3d& turn = {0, 0, 0}) {
    auto& pose = *found.images[image].submap_from_camera;
    pose = Transform<Submap, Camera>(RotationFromVector(turn) * pose.rotation(),
                                     pose.translation() + by);
  }
};

TEST(Prune, NamesNobodyInAGoodWalk) { EXPECT_THAT(Walk().Find(), IsEmpty()); }

TEST(Prune, NamesTheImageFarFromItsPosition) {
  Walk walk;
  walk.Move(17, {8, 0, 0});
  const auto found = walk.Find();
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].image, 17u);
  EXPECT_THAT(found[0].reason, HasSubstr("8.0 m from its GNSS position"));
}

TEST(Prune, AcceptsAnOffsetThatAllImagesShare) {
  Walk walk;
  for (std::size_t i = 0; i < 40; ++i) walk.Move(i, {0, 0, 12});
  EXPECT_THAT(walk.Find(), IsEmpty());
}

TEST(Prune, NamesTheImageThatTurnedAgainstBothNeighbours) {
  Walk walk;
  walk.Move(20, {0, 0, 0}, {0, 0, 0.3});
  walk.Move(39, {0, 0, 0}, {0, 0, 0.3});  // the last one: either of the two may be wrong
  const auto found = walk.Find();
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].image, 20u);
  EXPECT_THAT(found[0].reason, HasSubstr("gyroscope"));
}

TEST(Prune, WithoutGnssSpeedStillTells) {
  Walk walk;
  for (VerificationImage& image : walk.images) image.gnss_in_submap.reset();
  walk.Move(20, {0, 0, 30});
  const auto found = walk.Find();
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].image, 20u);
}

TEST(Prune, NamesNobodyWhenTheWholeIsBent) {
  Walk walk;
  for (std::size_t i = 0; i < 10; ++i) walk.Move(i, {20, 0, 0});
  EXPECT_THAT(walk.Find(), IsEmpty());
}

TEST(Prune, NamesNobodyAtABentEnd) {
  Walk walk;
  const std::array bend_m{1.2, 2.4, 3.9, 5.7, 7.8};
  for (std::size_t k = 0; k < bend_m.size(); ++k) walk.Move(35 + k, {0, 0, bend_m[k]});
  EXPECT_THAT(walk.Find(), IsEmpty());
}

/// The same street driven past again and again, ten images a time; GNSS has an offset each time.
struct Street {
  explicit Street(std::vector<Eigen::Vector3d> gnss_offsets) {
    const Reconstruction once = MakeWalk(10);
    const std::vector<VerificationImage> measured = MeasureWalk(once);
    found = once;
    found.images.clear();
    found.points.clear();
    for (std::size_t drive = 0; drive < gnss_offsets.size(); ++drive) {
      for (std::size_t i = 0; i < measured.size(); ++i) {
        found.images.push_back(once.images[i]);
        VerificationImage image = measured[i];
        image.time += std::chrono::seconds(60 * drive);
        image.gnss_in_submap =
            Point<Submap>(once.images[i].submap_from_camera->translation() + gnss_offsets[drive]);
        images.push_back(image);
      }
    }
  }
  std::vector<ImplausibleImage> Find() const {
    return *FindImplausibleImages(found, images, {}, {});
  }

  Reconstruction found;
  std::vector<VerificationImage> images;
};

TEST(Prune, NamesADriveWhosePicturesAllCarryLateTimes) {
  const auto found = Street({{0, 1, 0}, {0, 9, 0}, {1, 0, 0}, {-1, -1, 0}}).Find();
  ASSERT_THAT(found, SizeIs(10));
  EXPECT_EQ(found.front().image, 10u);
  EXPECT_EQ(found.back().image, 19u);
  EXPECT_THAT(found.front().reason, HasSubstr("its drive past stands"));
}

TEST(Prune, OfTwoDrivesApartNobodyKnowsWhichIsWrong) {
  EXPECT_THAT(Street({{0, 0, 0}, {0, 9, 0}}).Find(), IsEmpty());
}

TEST(Prune, DrivesThatAllStandApartAreGnssBeingPoor) {
  EXPECT_THAT(Street({{0, 0, 0}, {0, 9, 0}, {9, 0, 0}, {-9, 0, 0}}).Find(), IsEmpty());
}

TEST(Prune, ReceiversMayErrAsTheySay) {
  Street street({{0, 1, 0}, {0, 9, 0}, {1, 0, 0}, {-1, -1, 0}});
  for (VerificationImage& image : street.images) image.gnss_sigma_m = 3;
  EXPECT_THAT(street.Find(), IsEmpty());
}

TEST(Prune, ACamerasNeighbourOnTheRigIsNoFurtherWitness) {
  Street street({{0, 0, 0}, {0, 9, 0}});
  const std::size_t count = street.images.size();
  for (std::size_t i = 0; i < count; ++i) {
    street.found.images.push_back(street.found.images[i]);
    street.images.push_back(street.images[i]);
    street.images.back().sequence = "cam1";
  }
  EXPECT_THAT(street.Find(), IsEmpty());
}

TEST(Prune, RemovingAnImageRemovesWhatOnlyItSaw) {
  Walk walk;
  walk.found.points.resize(2);
  walk.found.points[0].track = {{16, 0}, {17, 0}};
  walk.found.points[1].track = {{15, 1}, {16, 1}, {17, 1}};
  const std::vector<ImplausibleImage> gone{{17, "wrong"}};
  RemoveImages(gone, walk.found);
  EXPECT_FALSE(walk.found.images[17].submap_from_camera);
  EXPECT_EQ(walk.found.images[17].exclusion, "wrong");
  ASSERT_THAT(walk.found.points, SizeIs(1));
  EXPECT_THAT(walk.found.points[0].track, SizeIs(2));
}

}  // namespace
}  // namespace waymark::mapping

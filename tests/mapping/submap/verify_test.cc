// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/verify.h"

#include <gmock/gmock.h>

#include "tests/mapping/submap/walk.h"

namespace waymark::mapping {
namespace {

using ::testing::HasSubstr;

/// A good walk to spoil, with what its sensors said.
struct Walk {
  Reconstruction found = MakeWalk(40);
  std::vector<VerificationImage> images = MeasureWalk(found);
  std::vector<MeasuredRotation> rotations = MeasureRotations(found);

  VerificationEvidence Verify(const VerificationOptions& options = {}) const {
    return *VerifyReconstruction(found, images, rotations, options);
  }
  void Turn(std::size_t image, const Eigen::Vector3d& rotation_vector) {
    auto& pose = *found.images[image].submap_from_camera;
    pose = Transform<Submap, Camera>(RotationFromVector(rotation_vector) * pose.rotation(),
                                     pose.translation());
  }
};

TEST(Verify, AcceptsAGoodWalkWithFigures) {
  const VerificationEvidence evidence = Walk().Verify();
  EXPECT_TRUE(evidence.accepted) << evidence.verdict;
  EXPECT_THAT(evidence.verdict, HasSubstr("40 of 40 own images"));
  EXPECT_THAT(evidence.verdict, HasSubstr("gyroscope within 0.0000 rad"));
  EXPECT_NEAR(evidence.max_speed_mps, 10, 1e-6);
  EXPECT_NEAR(evidence.max_gravity_error_rad, 0, 1e-7);
  EXPECT_EQ(evidence.mean_reprojection_px, 0.5);
}

TEST(Verify, SaysWhichSensorsWereAbsent) {
  Walk walk;
  walk.rotations.clear();
  for (VerificationImage& image : walk.images) image.up_in_camera.reset();
  const VerificationEvidence evidence = walk.Verify();
  EXPECT_TRUE(evidence.accepted);
  EXPECT_THAT(evidence.verdict, HasSubstr("no gyroscope"));
  EXPECT_THAT(evidence.verdict, HasSubstr("gravity unknown"));
}

TEST(Verify, RejectsAWarpedWalkByTheGyroscope) {
  Walk walk;
  for (std::size_t i = 0; i < 40; ++i) walk.Turn(i, {0, 0, 0.05 * static_cast<double>(i)});
  const VerificationEvidence evidence = walk.Verify();
  EXPECT_FALSE(evidence.accepted);
  EXPECT_THAT(evidence.verdict, HasSubstr("39 of 39 relative rotations contradict the gyroscope"));
  EXPECT_NEAR(evidence.max_gyroscope_error_rad, 0.05, 1e-6);
}

TEST(Verify, ToleratesOneBadImage) {
  Walk walk;
  walk.Turn(39, {0, 0, 0.5});
  const VerificationEvidence evidence = walk.Verify();
  EXPECT_TRUE(evidence.accepted) << evidence.verdict;
  EXPECT_NEAR(evidence.max_gyroscope_error_rad, 0.5, 1e-6);
}

TEST(Verify, RejectsALeaningWalk) {
  Walk walk;
  for (std::size_t i = 0; i < 40; ++i) walk.Turn(i, {0.2, 0, 0});
  EXPECT_THAT(walk.Verify().verdict, HasSubstr("leans by 0.200 rad"));
}

TEST(Verify, RejectsImpossibleSpeed) {
  Walk walk;
  for (std::size_t i = 0; i < 40; ++i) {
    auto& pose = *walk.found.images[i].submap_from_camera;
    pose = Transform<Submap, Camera>(pose.rotation(), 8 * pose.translation());
  }
  EXPECT_THAT(walk.Verify().verdict, HasSubstr("39 of 39 steps are faster than 60 m/s"));
}

TEST(Verify, RejectsAWalkFarFromGnss) {
  Walk walk;
  for (VerificationImage& image : walk.images) {
    image.gnss_in_submap =
        Point<Submap>(image.gnss_in_submap->coordinates() + Eigen::Vector3d(30, 0, 0));
  }
  EXPECT_THAT(walk.Verify().verdict, HasSubstr("30.0 m (median) away from GNSS"));
}

TEST(Verify, RejectsTooFewImagesAndBlurredPoints) {
  Walk few;
  for (std::size_t i = 5; i < 40; ++i) few.found.images[i].submap_from_camera.reset();
  EXPECT_THAT(few.Verify().verdict, HasSubstr("too few images joined: 5 of 40 own ones"));
  Walk blurred;
  blurred.found.mean_reprojection_px = 3;
  EXPECT_THAT(blurred.Verify().verdict, HasSubstr("reprojection error of 3.00 px"));
  Walk empty;
  empty.found.points.clear();
  EXPECT_THAT(empty.Verify().verdict, HasSubstr("too few landmarks: 0"));
}

TEST(Verify, RefusesWrongInput) {
  Walk walk;
  EXPECT_FALSE(VerifyReconstruction(walk.found, {}, {}, {}).ok());
  EXPECT_FALSE(
      VerifyReconstruction(walk.found, walk.images, walk.rotations, {.min_images = 1}).ok());
  walk.rotations[0].to = 40;
  EXPECT_FALSE(VerifyReconstruction(walk.found, walk.images, walk.rotations, {}).ok());
}

}  // namespace
}  // namespace waymark::mapping

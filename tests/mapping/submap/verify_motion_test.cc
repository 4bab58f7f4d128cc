// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "mapping/submap/verify.h"
#include "mapping/synthetic/fault.h"
#include "tests/mapping/submap/walk.h"

namespace waymark::mapping {
namespace {

using ::testing::HasSubstr;

/// A drive to be spoilt after its sensors have measured it.
struct Drive {
  Reconstruction found = MakeWalk(60);
  std::vector<VerificationImage> images = MeasureWalk(found);
  std::vector<MeasuredRotation> rotations = MeasureRotations(found);

  VerificationEvidence Verify(const VerificationOptions& options = {}) const {
    return *VerifyReconstruction(found, images, rotations, options);
  }
  void Pose(std::size_t image, const Eigen::Quaterniond& rotation,
            const Eigen::Vector3d& position) {
    found.images[image].submap_from_camera = Transform<Submap, Camera>(rotation, position);
  }
  const Transform<Submap, Camera>& Pose(std::size_t image) const {
    return *found.images[image].submap_from_camera;
  }
  /// What the sensors say follows the reconstruction.
  void MeasureAgain() {
    images = MeasureWalk(found);
    rotations = MeasureRotations(found);
  }
};

/// Position and heading of a level camera at every image, at ten images a second.
Drive DriveAlong(const std::function<Eigen::Vector3d(double)>& position_and_yaw) {
  Drive drive;
  for (std::size_t i = 0; i < 60; ++i) {
    const Eigen::Vector3d at = position_and_yaw(0.1 * static_cast<double>(i));
    const Eigen::Quaterniond level(Eigen::AngleAxisd(at.z(), Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitX()));
    drive.Pose(i, level, {at.x(), at.y(), 0});
  }
  drive.MeasureAgain();
  return drive;
}

const VerificationFigure* Find(const VerificationEvidence& evidence, const std::string& name) {
  for (const VerificationFigure& figure : evidence.figures) {
    if (figure.name == name) return &figure;
  }
  return nullptr;
}

TEST(VerifyMotion, KnowsAVehicleAndKeepsItsFigures) {
  const VerificationEvidence evidence = Drive().Verify();
  EXPECT_TRUE(evidence.accepted) << evidence.verdict;
  EXPECT_THAT(evidence.verdict, HasSubstr("a vehicle, sideways within"));
  const VerificationFigure* sideways = Find(evidence, "sideways_rad");
  ASSERT_NE(sideways, nullptr);
  EXPECT_EQ(sideways->broken, 0);
  EXPECT_GT(sideways->count, 25);
  EXPECT_LT(sideways->value, 0.01);
  EXPECT_NEAR(Find(evidence, "curvature_per_m")->value, 0.02, 1e-3);
  EXPECT_NE(Find(evidence, "scale_drift_m"), nullptr);
}

TEST(VerifyMotion, RejectsAVehicleThatSlidesSideways) {
  const Drive drive =
      DriveAlong([](double t) {  // for a second it moves at 20 degrees to its heading
        return Eigen::Vector3d(t > 2 ? 3 * std::min(t - 2, 1.0) : 0, 8 * t, 0);
      });
  const VerificationEvidence evidence = drive.Verify();
  EXPECT_FALSE(evidence.accepted);
  EXPECT_THAT(evidence.verdict, HasSubstr("steps of the vehicle are sideways"));
  EXPECT_TRUE(drive.Verify({.recorder = Recorder::kPerson}).accepted);
}

TEST(VerifyMotion, RejectsAVehicleThatTurnsOnTheSpot) {
  const Drive drive = DriveAlong([](double t) {  // a circle of 2 m at 8 m/s, for half a second
    const double turn = 4 * std::clamp(t - 2, 0.0, 0.6);
    return Eigen::Vector3d(
        -2 * (1 - std::cos(turn)) - 8 * std::sin(turn) * std::max(0.0, t - 2.6),
        8 * std::min(t, 2.0) + 2 * std::sin(turn) + 8 * std::cos(turn) * std::max(0.0, t - 2.6),
        turn);
  });
  EXPECT_FALSE(drive.Verify({.max_acceleration_mps2 = 100}).accepted);
  EXPECT_THAT(drive.Verify({.max_acceleration_mps2 = 100}).verdict,
              HasSubstr("turns of the vehicle are too tight"));
}

TEST(VerifyMotion, ThoseOnFootMayMoveSideways) {
  const Drive drive = DriveAlong([](double t) {  // a metre aside and back, looking elsewhere
    return Eigen::Vector3d(std::sin(t), 1.2 * t, 0.8 * std::sin(2 * t));
  });
  const VerificationEvidence evidence = drive.Verify();
  EXPECT_TRUE(evidence.accepted) << evidence.verdict;
  EXPECT_THAT(evidence.verdict, HasSubstr("no vehicle"));
  EXPECT_EQ(Find(evidence, "sideways_rad"), nullptr);
  EXPECT_FALSE(drive.Verify({.recorder = Recorder::kVehicle}).accepted);
}

TEST(VerifyMotion, AcceptsStopAndGoAndReversing) {
  const Drive stop = DriveAlong([](double t) {  // 8 m/s, 2 s of rest, 8 m/s
    const double y = t < 2 ? 8 * t - 2 * t * t : t < 4 ? 8 : 8 + 2 * (t - 4) * (t - 4);
    return Eigen::Vector3d(0, y, 0);
  });
  EXPECT_TRUE(stop.Verify().accepted) << stop.Verify().verdict;
  const Drive reverse =
      DriveAlong([](double t) { return Eigen::Vector3d(0, 9 - (t - 3) * (t - 3) * 1.5, 0); });
  EXPECT_TRUE(reverse.Verify().accepted) << reverse.Verify().verdict;
}

TEST(VerifyMotion, OneMisplacedImageIsNoTear) {
  Drive drive;
  drive.Pose(30, drive.Pose(30).rotation(),
             drive.Pose(30).translation() + Eigen::Vector3d(0, 0, 9));
  const VerificationEvidence evidence = drive.Verify();
  EXPECT_TRUE(evidence.accepted) << evidence.verdict;
  EXPECT_GT(Find(evidence, "velocity_change_mps")->broken, 0);
  EXPECT_EQ(Find(evidence, "tear_mps")->broken, 0);
}

TEST(VerifyMotion, OneStepThatDividesTheSubmapIsATear) {
  Drive drive;
  for (std::size_t i = 30; i < 60; ++i) {
    drive.Pose(i, drive.Pose(i).rotation(),
               drive.Pose(i).translation() - 4 * Eigen::Vector3d::UnitY());
  }
  EXPECT_THAT(drive.Verify().verdict, HasSubstr("steps tear the path"));
}

TEST(VerifyMotion, StandingStillAtOnceIsATear) {
  Drive drive;
  for (std::size_t i = 41; i < 60; ++i) {
    drive.Pose(i, drive.Pose(40).rotation(), drive.Pose(40).translation());
  }
  drive.rotations.clear();
  EXPECT_THAT(drive.Verify().verdict, HasSubstr("tear the path"));
}

TEST(VerifyRotation, RejectsABendTooSlowForPairs) {
  Drive drive;
  for (std::size_t i = 0; i < 60; ++i) {  // out and back again, 0.004 rad between neighbours
    const double turn = 0.004 * (30 - std::abs(static_cast<double>(i) - 30));
    drive.Pose(i, RotationFromVector({0, 0, turn}) * drive.Pose(i).rotation(),
               drive.Pose(i).translation());
  }
  const VerificationEvidence evidence = drive.Verify();
  EXPECT_THAT(evidence.verdict, HasSubstr("orientations drift from the gyroscope"));
  EXPECT_EQ(Find(evidence, "gyroscope_rad")->broken, 0);
}

TEST(VerifyRotation, ABiasIsForgivenAndABendIsNot) {
  const auto turned = [](double rad_per_s) {
    Drive drive;
    for (MeasuredRotation& rotation : drive.rotations) {
      rotation.to_from_from = RotationFromVector({0, 0.1 * rad_per_s, 0}) * rotation.to_from_from;
    }
    return drive.Verify();
  };
  EXPECT_TRUE(turned(0.005).accepted) << turned(0.005).verdict;
  EXPECT_NEAR(Find(turned(0.005), "gyroscope_bias_rad_per_s")->value, 0.005, 5e-4);
  EXPECT_THAT(turned(0.012).verdict, HasSubstr("turns steadily against the gyroscope"));
}

TEST(VerifyShape, RejectsScaleThatDrifts) {
  Drive drive;
  Eigen::Vector3d position = drive.Pose(0).translation();
  for (std::size_t i = 1; i < 60; ++i) {
    const Eigen::Vector3d step = drive.images[i].gnss_in_submap->coordinates() -
                                 drive.images[i - 1].gnss_in_submap->coordinates();
    position += (0.7 + 0.01 * static_cast<double>(i)) * step;
    drive.Pose(i, drive.Pose(i).rotation(), position);
  }
  const VerificationEvidence evidence = drive.Verify();
  EXPECT_THAT(evidence.verdict, HasSubstr("its scale drifts against GNSS"));
  EXPECT_GT(Find(evidence, "scale_drift_m")->value, 1);
}

TEST(VerifyShape, GnssThatJumpsIsNotFollowed) {
  Drive drive;
  for (std::size_t i = 35; i < 60; ++i) {
    drive.images[i].gnss_in_submap =
        Point<Submap>(drive.images[i].gnss_in_submap->coordinates() + Eigen::Vector3d(25, 0, 0));
  }
  const VerificationEvidence evidence = drive.Verify();
  EXPECT_TRUE(evidence.accepted) << evidence.verdict;
  EXPECT_FALSE(evidence.gnss_is_trusted);
  EXPECT_THAT(evidence.verdict, HasSubstr("GNSS is wrong by 25.0 m and not followed"));
}

TEST(VerifyShape, AJumpBesideAnImpossibleMotionIsNotBlamedOnGnss) {
  Drive drive;  // ten metres a second, and at the very end it stands
  for (std::size_t i = 50; i < 60; ++i) {
    drive.Pose(i, drive.Pose(49).rotation(), drive.Pose(49).translation());
  }
  drive.rotations.clear();
  EXPECT_FALSE(drive.Verify().accepted);
  EXPECT_TRUE(drive.Verify().gnss_is_trusted);
}

TEST(VerifyShape, ABendAgainstGnssIsJudgedByTheGyroscope) {
  Drive drive;  // GNSS says that it turned less than the images do
  const double cut = 0.3;
  Eigen::Vector3d position = drive.Pose(0).translation();
  for (std::size_t i = 1; i < 60; ++i) {
    const Eigen::Vector3d step = drive.Pose(i).translation() - drive.Pose(i - 1).translation();
    position += RotationFromVector({0, 0, -cut * static_cast<double>(i) / 60}) * step;
    drive.images[i].gnss_in_submap = Point<Submap>(position);
  }
  const VerificationEvidence with = drive.Verify();
  EXPECT_TRUE(with.accepted) << with.verdict;
  EXPECT_FALSE(with.gnss_is_trusted);
  drive.rotations.clear();
  EXPECT_THAT(drive.Verify().verdict, HasSubstr("is bent against GNSS"));
}

TEST(VerifyShape, ATurnThatTheGyroscopeMayHaveForABiasIsToldByGnss) {
  constexpr double kTurnRadPerS = 0.008;  // a gyroscope may err so, and GNSS sees it in 12 s
  Drive drive{.found = MakeWalk(120)};
  const auto true_images = drive.images;
  Bend({.yaw_rad = 12 * kTurnRadPerS}, drive.found);
  drive.images = MeasureWalk(drive.found);
  EXPECT_TRUE(drive.Verify().accepted) << "GNSS agrees: a bias. " << drive.Verify().verdict;
  drive.images = true_images;
  EXPECT_THAT(drive.Verify().verdict, HasSubstr("is bent against GNSS"));
}

}  // namespace
}  // namespace waymark::mapping

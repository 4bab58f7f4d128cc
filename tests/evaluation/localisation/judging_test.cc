// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/judging.h"

#include <gmock/gmock.h>

namespace waymark::evaluation {
namespace {

const CameraModel kCamera =
    *CameraModel::Create(CameraKind::kSimplePinhole, 640, 480, std::vector<double>{500, 320, 240});

Question AskFrom(const Rigid3& map_from_camera) {
  return {"day", {mapping::ImageFeatures{}, kCamera, std::nullopt, std::nullopt}, map_from_camera};
}

localiser::Localisation Answer(const Rigid3& map_from_camera, double sigma_m, double sigma_rad) {
  localiser::Localisation answer;
  answer.status = localiser::LocalisationStatus::kLocalised;
  answer.pose = localiser::LocalisedPose{.map_from_camera = Transform<Map, Camera>(map_from_camera),
                                         .covariance = Eigen::Matrix<double, 6, 6>::Identity(),
                                         .submap = SubmapId("a"),
                                         .submap_from_camera = {}};
  answer.pose->covariance.topLeftCorner<3, 3>() *= sigma_m * sigma_m;
  answer.pose->covariance.bottomRightCorner<3, 3>() *= sigma_rad * sigma_rad;
  return answer;
}

TEST(Judging, MeasuresErrorsInMetresDegreesAndStatedSigmas) {
  const Rigid3 truth(RotationFromVector({0.3, -1, 0.2}), Eigen::Vector3d(4, 5, 6));
  Eigen::Matrix<double, 6, 1> error;
  error << 0.3, 0, 0.4, 0, 0.02, 0;
  const Verdict verdict = Judge(AskFrom(truth), Answer(Perturb(truth, error), 0.25, 0.01));
  EXPECT_NEAR(verdict.error_m, 0.5, 1e-12);
  EXPECT_NEAR(verdict.error_deg, 0.02 * 180 / M_PI, 1e-9);
  EXPECT_NEAR(verdict.position_squares, 4, 1e-9);
  EXPECT_NEAR(verdict.rotation_squares, 4, 1e-9);
  EXPECT_NEAR(verdict.pose_squares, 8, 1e-9);
  EXPECT_FALSE(verdict.IsFalse());
  EXPECT_TRUE(Judge(AskFrom(Rigid3()), Answer(truth, 0.1, 0.1)).IsFalse());
}

TEST(Judging, CountsByKindAndByBounds) {
  const std::vector<Verdict> verdicts{{.kind = "day", .is_accepted = true, .error_m = 0.05},
                                      {.kind = "day", .is_accepted = true, .error_m = 0.2},
                                      {.kind = "day", .is_accepted = true, .error_m = 1.2},
                                      {.kind = "night", .is_accepted = false}};
  const Recall day = Count(verdicts, "day");
  EXPECT_EQ(day.requests, 3);
  EXPECT_EQ(day.within_10cm_1deg, 1);
  EXPECT_EQ(day.within_25cm_2deg, 2);
  EXPECT_EQ(day.false_poses, 1);
  EXPECT_EQ(Count(verdicts).requests, 4);
  EXPECT_EQ(Count(verdicts).accepted, 3);
}

TEST(Judging, BoundsRatesAsClopperAndPearsonDo) {
  EXPECT_NEAR(UpperBound95(0, 3000), 1 - std::pow(0.05, 1 / 3000.0), 1e-9);
  EXPECT_NEAR(UpperBound95(1, 10), 0.3942, 1e-4);
  EXPECT_NEAR(UpperBound95(5, 5000), 0.002102, 1e-5);
  EXPECT_EQ(UpperBound95(3, 3), 1);
}

TEST(Judging, CalibrationTellsHowMuchTooSureACovarianceIs) {
  simulator::Random random(1);
  std::vector<Verdict> verdicts;
  for (int i = 0; i < 4000; ++i) {
    const double position = random.NormalVector(2).squaredNorm();  // twice the stated sigma
    const double rotation = random.NormalVector(1).squaredNorm();
    verdicts.push_back({.kind = "day",
                        .is_accepted = true,
                        .position_squares = position,
                        .rotation_squares = rotation,
                        .pose_squares = position + rotation});
  }
  const Calibration found = Calibrate(verdicts);
  EXPECT_EQ(found.poses, 4000);
  EXPECT_NEAR(found.rotation_inside, 0.95, 0.015);
  EXPECT_LT(found.position_inside, 0.6);
  EXPECT_NEAR(found.position_factor, 2, 0.1);
  EXPECT_NEAR(found.rotation_factor, 1, 0.05);
}

TEST(Judging, PhonesErrAsMuchAsStated) {
  simulator::Random random(3);
  for (int i = 0; i < 50; ++i) {
    Question question = AskFrom(Rigid3(RotationFromVector({0.1, 0.2, 0.3}), {10, 20, 1}));
    AddSenses({}, random, question);
    const Eigen::Vector3d error =
        question.request.prior->position.coordinates() - question.map_from_camera.translation();
    EXPECT_GE(error.norm(), 5 - 1e-9);
    EXPECT_LE(error.norm(), 20 + 1e-9);
    const Eigen::Vector3d up = question.map_from_camera.rotation() * *question.request.up_in_camera;
    EXPECT_GT(up.z(), std::cos(Angle::Degrees(6).radians()));
  }
}

}  // namespace
}  // namespace waymark::evaluation

// SPDX-License-Identifier: Apache-2.0
// What the height of a vehicle's camera above the road says about scale.
#include <gmock/gmock.h>

#include <random>

#include "mapping/submap/verify.h"
#include "mapping/synthetic/fault.h"
#include "tests/mapping/submap/walk.h"

namespace waymark::mapping {
namespace {

using ::testing::HasSubstr;

constexpr double kHeightM = 1.6;

/// A drive of 60 m with the road beneath it.
class VerifyRoad : public testing::Test {
 protected:
  void SetUp() override {
    std::uniform_real_distribution<double> beside(-1.5, 1.5), ahead(4, 12);
    std::normal_distribution<double> noise(0, 0.02);
    for (std::size_t i = 0; i < found_.images.size(); ++i) {
      for (int k = 0; k < 10; ++k) {
        const Eigen::Vector3d in_camera(beside(random_), kHeightM + noise(random_), ahead(random_));
        AddPoint(i, in_camera);
      }
    }
  }

  void AddPoint(std::size_t image, const Eigen::Vector3d& in_camera) {
    const auto& pose = *found_.images[image].submap_from_camera;
    found_.points.push_back(
        {Point<Submap>(pose.translation() + pose.rotation() * in_camera),
         {{static_cast<std::uint32_t>(image), 0}, {static_cast<std::uint32_t>(image + 1), 0}}});
  }

  /// As a receiver's errors are: alike for seconds.
  void BlurGnss(double sigma_m) {
    std::normal_distribution<double> normal(0, sigma_m);
    Eigen::Vector3d error = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < images_.size(); ++i) {
      if (i % 10 == 0) error = {normal(random_), normal(random_), 0};
      images_[i].gnss_in_submap = Point<Submap>(images_[i].gnss_in_submap->coordinates() + error);
    }
  }

  void RemoveRoad() {
    std::erase_if(found_.points, [](const ReconstructedPoint& point) {
      return point.position.coordinates().z() < 0;
    });
  }

  VerificationEvidence Verify(const VerificationOptions& options = {}) const {
    return *VerifyReconstruction(found_, images_, rotations_, options);
  }

  static const VerificationFigure* Find(const VerificationEvidence& evidence,
                                        const std::string& name) {
    for (const VerificationFigure& figure : evidence.figures) {
      if (figure.name == name) return &figure;
    }
    return nullptr;
  }

  std::mt19937_64 random_{3};
  Reconstruction found_ = MakeWalk(60);
  std::vector<VerificationImage> images_ = MeasureWalk(found_);
  std::vector<MeasuredRotation> rotations_ = MeasureRotations(found_);
};

TEST_F(VerifyRoad, ADriftThatGnssCannotSeeShows) {
  BlurGnss(1);
  EXPECT_TRUE(Verify().accepted) << Verify().verdict;
  DriftScale(1.35, found_);
  EXPECT_THAT(Verify().verdict, HasSubstr("its scale drifts against GNSS and the road"));
  RemoveRoad();
  EXPECT_TRUE(Verify().accepted) << "nothing is left that could tell: " << Verify().verdict;
}

TEST_F(VerifyRoad, SmallDriftsAreMeasured) {
  DriftScale(1.06, found_);
  const VerificationEvidence evidence = Verify();
  const VerificationFigure* figure = Find(evidence, "scale_drift_by_road_m");
  ASSERT_NE(figure, nullptr);
  // From 0.97 to 1.03 along 60 m; the best similarity takes a part.
  EXPECT_GT(figure->value, 0.2);
  EXPECT_LT(figure->value, 0.6);
  EXPECT_TRUE(evidence.accepted) << evidence.verdict;
}

TEST_F(VerifyRoad, GnssThatRunsAwayAlongTheWayIsNotFollowed) {
  Eigen::Vector3d place = images_[0].gnss_in_submap->coordinates();
  std::vector<Eigen::Vector3d> steps;
  for (std::size_t i = 1; i < images_.size(); ++i) {
    steps.push_back(images_[i].gnss_in_submap->coordinates() -
                    images_[i - 1].gnss_in_submap->coordinates());
  }
  for (std::size_t i = 1; i < images_.size(); ++i) {
    place += (0.7 + 0.01 * static_cast<double>(i)) * steps[i - 1];
    images_[i].gnss_in_submap = Point<Submap>(place);
  }
  EXPECT_TRUE(Verify().accepted) << Verify().verdict;
  EXPECT_FALSE(Verify().gnss_is_trusted);
  RemoveRoad();
  EXPECT_THAT(Verify().verdict, HasSubstr("its scale drifts against GNSS,"));
}

// GNSS wandered off and the reconstruction went with it: GNSS says that all is well, the road that
// it is not. They cannot both be right, and what follows GNSS is not acquitted by it.
TEST_F(VerifyRoad, GnssThatTookTheReconstructionAlongDoesNotAcquitIt) {
  DriftScale(1.14, found_);
  images_ = MeasureWalk(found_);
  EXPECT_GT(Find(Verify(), "scale_drift_by_road_m")->value, 0.5);
  EXPECT_THAT(Verify().verdict, HasSubstr("its scale drifts against GNSS and the road"));
  RemoveRoad();
  EXPECT_TRUE(Verify().accepted) << "nobody contradicts: " << Verify().verdict;
}

TEST_F(VerifyRoad, KerbsAndCarsDoNotPassForTheRoad) {
  std::uniform_real_distribution<double> beside(-1.5, 1.5), ahead(4, 12), up(0.3, 1.2);
  for (std::size_t i = 0; i < found_.images.size(); ++i) {
    // More and more lies on the road: heights above it shrink, but not those of most points.
    for (std::size_t k = 0; k < i / 10; ++k) {
      AddPoint(i, {beside(random_), kHeightM - up(random_), ahead(random_)});
    }
  }
  BlurGnss(0.5);
  const VerificationEvidence evidence = Verify();
  EXPECT_TRUE(evidence.accepted) << evidence.verdict;
  EXPECT_LT(Find(evidence, "scale_drift_by_road_m")->value, 0.3);
}

TEST_F(VerifyRoad, ThoseOnFootHoldTheirPhonesAsTheyLike) {
  DriftScale(1.05, found_);
  EXPECT_EQ(Find(Verify({.recorder = Recorder::kPerson}), "scale_drift_by_road_m"), nullptr);
}

}  // namespace
}  // namespace waymark::mapping

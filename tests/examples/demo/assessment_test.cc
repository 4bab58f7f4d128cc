// SPDX-License-Identifier: Apache-2.0
#include "examples/demo/assessment.h"

#include <gmock/gmock.h>

#include "examples/demo/promises.h"
#include "mapping/base/quantile.h"
#include "tests/support/random_geometry.h"

namespace waymark::demo {
namespace {

const Eigen::Vector3d kAnchorInMap(3, 4, 5);

/// A phone that walks ten metres east and believes itself off by `error` in the map, which lies in
/// the true world as it is.
WalkedPhone Walker(const std::string& name, const Eigen::Vector3d& error) {
  support::RandomGeometry random(7);
  WalkedPhone phone;
  phone.result.name = name;
  phone.result.keyframes_sent = phone.result.fixes = 20;
  for (int i = 0; i < 20; ++i) {
    const std::string image = std::to_string(i) + ".jpg";
    const Rigid3 truth(random.Rotation(), {0.5 * i, 0, 1.6});
    phone.truth[image] = truth;
    BelievedPose belief{.image = image,
                        .seconds = 0.5 * i,
                        .state = "fixed",
                        .map_from_camera = std::nullopt,
                        .others_present = 2};
    if (i > 0) {
      belief.map_from_camera =
          Transform<Map, Camera>(truth.rotation(), truth.translation() + error);
    }
    phone.result.track.push_back(belief);
  }
  phone.result.anchors.push_back(
      {"a", Transform<Map, Anchor>(Eigen::Quaterniond::Identity(), kAnchorInMap), 1.0});
  return phone;
}

TEST(Assessment, MeasuresTheErrorOfABelievedPose) {
  const PhoneFigures figures = AssessPhone(Walker("a", {0.03, 0, 0.04}), MapAlignment{});
  EXPECT_NEAR(figures.median_error_m, 0.05, 1e-9);
  EXPECT_NEAR(figures.max_error_m, 0.05, 1e-9);
  EXPECT_NEAR(figures.median_error_deg, 0, 1e-5);
  EXPECT_EQ(figures.frames, 20);
  EXPECT_EQ(figures.frames_with_pose, 19);
  EXPECT_NEAR(figures.first_fix_s, 0.5, 1e-12);
}

TEST(Assessment, AnAnchorIsShownWhereThePhonesErrorPutsIt) {
  auto owner = Walker("owner", Eigen::Vector3d::Zero());
  owner.result.placed = "a";
  const auto anchors = AssessAnchors({owner, Walker("other", {-0.1, 0, 0})});
  ASSERT_EQ(anchors.size(), 1u);
  EXPECT_NEAR(anchors[0].spread_cm, 10, 1e-6);
  EXPECT_EQ(anchors[0].agreement_pairs, 19) << "frames of which both know where they were";
  EXPECT_NEAR(anchors[0].agreement_p50_cm, 10, 1e-6);
  EXPECT_NEAR(anchors[0].agreement_p95_cm, 10, 1e-6);
  EXPECT_LT((*anchors[0].views[0].shown_in_world - kAnchorInMap).norm(), 1e-9);
  EXPECT_LT(
      (*anchors[0].views[1].shown_in_world - kAnchorInMap - Eigen::Vector3d(0.1, 0, 0)).norm(),
      1e-9);
}

TEST(Promises, AreBrokenByAPhoneThatNeverHeardOfTheAnchor) {
  auto owner = Walker("owner", Eigen::Vector3d::Zero());
  owner.result.placed = "a";
  auto deaf = Walker("deaf", Eigen::Vector3d::Zero());
  const auto kept = [](const std::vector<WalkedPhone>& phones) {
    std::vector<PhoneFigures> figures;
    for (const auto& phone : phones) figures.push_back(AssessPhone(phone, MapAlignment{}));
    const auto promises = CheckPromises(phones, figures, AssessAnchors(phones), {});
    return std::all_of(promises.begin(), promises.end(), [](const auto& p) { return p.is_kept; });
  };
  EXPECT_TRUE(kept({owner, deaf}));
  deaf.result.anchors.clear();
  EXPECT_FALSE(kept({owner, deaf}));
}

TEST(Promises, AreBrokenWhenNothingHappened) {
  EXPECT_FALSE(CheckPromises({}, {}, {}, {}).back().is_kept);
}

TEST(Quantile, OfNothingIsZero) {
  EXPECT_EQ(Quantile({}, 0.5), 0);
  EXPECT_EQ(Quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(Quantile({3, 1, 2}, 1), 3);
}

}  // namespace
}  // namespace waymark::demo

// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "tests/evaluation/phone/phone_report.h"
#include "tests/evaluation/phone/svg.h"
#include "tests/evaluation/running.h"

namespace waymark::evaluation {
namespace {

using testing::DoubleNear;
using testing::HasSubstr;

Rigid3 At(double x) { return {Eigen::Quaterniond::Identity(), {x, 0, 0}}; }

/// Somebody who walks along x at 1 m/s for `seconds`; odometry is one per cent long, and what is
/// shown is beside the truth by `off_m`.
PhoneTrial Straight(int seconds, double off_m) {
  PhoneTrial trial;
  const Rigid3 off(Eigen::Quaterniond::Identity(), {0, off_m, 0});
  for (int i = 0; i <= 10 * seconds; ++i) {
    trial.shown.push_back(
        {.time_s = 0.1 * i,
         .map_from_device = At(0.1 * i),
         .vo_from_device = At(0.101 * i),
         .state = i < 20 ? localiser::AlignmentState::kCoarse : localiser::AlignmentState::kFixed,
         .shown = i < 20 ? At(50) : off * At(0.1 * i),
         .certainty = {},
         .by_newest_fix = std::nullopt,
         .update_ms = 0.01});
  }
  for (int i = 0; i <= seconds; i += 2) {
    trial.requests += 2;  // every other one fails
    trial.fixes.push_back({.time_s = 1.0 * i,
                           .map_from_device = At(i),
                           .localised_from_device = At(1.001 * i),
                           .map_error_m = 0.03,
                           .localisation_error_m = 0.04});
  }
  return trial;
}

TEST(PhoneErrors, CountFromTheFirstAgreementAndSplitIntoTheirParts) {
  const PhoneErrors errors = Assess(Straight(40, 0.05), 1);
  EXPECT_THAT(errors.shown.mean, DoubleNear(0.05, 1e-9));
  EXPECT_THAT(errors.first_fixed_s, DoubleNear(2, 1e-9));
  EXPECT_THAT(errors.budget.success_rate, DoubleNear(0.5, 1e-9));
  EXPECT_THAT(errors.budget.wait_s, DoubleNear(2, 1e-9));
  EXPECT_THAT(errors.budget.odometry_mps, DoubleNear(0.01, 1e-6));
  EXPECT_THAT(errors.budget.Sum(), DoubleNear(0.03 + 0.04 + 0.02, 1e-6));
  EXPECT_THAT(errors.budget.RootOfSquares(), DoubleNear(std::sqrt(0.0029), 1e-6));
  EXPECT_THAT(errors.largest_jump_m, DoubleNear(0.001, 1e-6)) << "odometry that is too long";
}

TEST(PhoneErrors, WithoutAnAnswerThereIsNothingToAssess) {
  PhoneTrial trial = Straight(1, 0);
  trial.fixes.clear();
  const PhoneErrors errors = Assess(trial, 1);
  EXPECT_EQ(errors.shown.count, 0U);
  EXPECT_LT(errors.first_fixed_s, 0);
  EXPECT_EQ(errors.budget.Sum(), 0);
}

TEST(PhoneErrors, RelativeOnesAreOverTheFirstAnswersSoFarApart) {
  const std::vector<PhoneTrial> trials{Straight(40, 0)};
  const std::vector<double> errors_m = RelativeErrors(trials, 20);
  ASSERT_EQ(errors_m.size(), 11U);
  EXPECT_THAT(errors_m, testing::Each(DoubleNear(0.02, 1e-9)));
}

TEST(Agreement, IsTheDistanceBetweenWhatTwoPhonesShow) {
  std::vector<PhoneTrial> trials{Straight(40, 0.05), Straight(40, -0.03)};
  for (PhoneTrial& trial : trials) {
    for (ShownInstant& instant : trial.shown) {
      instant.certainty = {std::hypot(0.04, localiser::AlignmentOptions{}.sigma_floor_m), 0};
    }
  }
  const std::vector<SharedLook> looks = SharedLooks(trials);
  ASSERT_GT(looks.size(), 100U);
  for (const SharedLook& look : looks) {
    EXPECT_THAT(look.apart_m, DoubleNear(0.08, 1e-9));
    EXPECT_THAT(look.expected.p50_m, DoubleNear(1.5382 * 0.04 * std::sqrt(2), 1e-4))
        << "both stand on the same map";
  }
  EXPECT_THAT(DescribeAgreement(looks), HasSubstr("8.0 cm apart"));
  EXPECT_TRUE(SharedLooks({trials.data(), 1}).empty()) << "with nobody";
}

TEST(Pictures, HoldWhatTheyShow) {
  EXPECT_THAT(DrawWalk(Straight(4, 0)), HasSubstr("where the phone truly was"));
  const std::vector<double> values{0.01, 0.02, 0.05, 9};
  const std::string histogram = DrawHistogram(values, 0.04, 3, "errors", "m");
  EXPECT_THAT(histogram, HasSubstr("errors"));
  EXPECT_THAT(histogram, HasSubstr("</svg>"));
}

TEST(Phones, WalkInTheSimulatedCityAndShowWhereTheyAre) {
  const ScratchFolder scratch(false);
  PhonePlan plan;
  MakeQuick(plan);
  const auto trials = RunPhones(plan, {scratch.path(), {}, {}});
  ASSERT_TRUE(trials.ok()) << ToString(trials.error());
  ASSERT_EQ(trials->size(), 1U);
  const PhoneErrors errors = Assess(trials->front(), plan.keyframe_interval_s);
  EXPECT_GT(errors.budget.success_rate, 0.5);
  EXPECT_GE(errors.first_fixed_s, 0);
  EXPECT_LT(errors.shown.median, 0.5);
}

}  // namespace
}  // namespace waymark::evaluation

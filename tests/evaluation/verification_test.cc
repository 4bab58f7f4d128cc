// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/evaluation/verification_trial.h"

namespace waymark::evaluation {
namespace {

// A small sample of what waymark-evaluate-verification measures.
TEST(Verification, FindsPlantedFaultsAndKeepsWhatIsSound) {
  const std::vector<PlantedFault> faults = PlantedFaults();
  int broken = 0, found = 0;
  for (const Route route : {Route::kCorner, Route::kOnFoot}) {
    const SimulatedDrive drive = MakeDrive(route, 42);
    const Result<BuiltSubmap> built = Build(drive);
    ASSERT_TRUE(built.ok()) << ToString(built.error());
    BuiltSubmap sound = *built;
    const auto evidence = PruneAndVerify(sound, {});
    ASSERT_TRUE(evidence.ok());
    EXPECT_TRUE(evidence->accepted) << evidence->verdict;
    EXPECT_FALSE(CompareWithTruth(sound).IsBroken());
    for (const PlantedFault& fault : faults) {
      if (!fault.spoil_outcome) continue;
      BuiltSubmap spoilt = *built;
      fault.spoil_outcome(spoilt);
      const auto verdict = PruneAndVerify(spoilt, {});
      ASSERT_TRUE(verdict.ok());
      if (!CompareWithTruth(spoilt).IsBroken()) continue;
      ++broken;
      found += !verdict->accepted;
      if (route == Route::kCorner) {
        EXPECT_FALSE(verdict->accepted) << fault.kind << ", " << fault.strength;
      }
    }
  }
  EXPECT_GT(broken, 30);
  EXPECT_GE(found, 9 * broken / 10);
}

TEST(Verification, LyingGnssIsNotFollowedAndImagesInTheWrongPlaceAreFound) {
  for (const PlantedFault& fault : PlantedFaults()) {
    const bool lies = fault.kind == "lying GNSS: jump" && fault.strength == "20 m";
    const bool loops =
        fault.kind == "wrong loop: looks alike" && fault.strength == "50 % of images";
    if (!lies && !loops) continue;
    SimulatedDrive drive = MakeDrive(Route::kCorner, 43);
    fault.spoil_recording(drive);
    Result<BuiltSubmap> built = Build(drive);
    ASSERT_TRUE(built.ok()) << ToString(built.error());
    const auto evidence = PruneAndVerify(*built, {});
    ASSERT_TRUE(evidence.ok());
    EXPECT_EQ(evidence->accepted, lies) << evidence->verdict;
    EXPECT_FALSE(lies && evidence->gnss_is_trusted) << evidence->verdict;
  }
}

TEST(Verification, EqualPlansGiveEqualTrials) {
  const TrialPlan plan{.drives = 1, .faults_per_strength = 1, .only = "mirrored"};
  const auto once = RunTrials(plan, {}, {1});
  const auto again = RunTrials(plan, {}, {2});
  ASSERT_EQ(once.size(), 2u);
  ASSERT_EQ(again.size(), 2u);
  EXPECT_EQ(once[1].kind, "mirrored");
  EXPECT_EQ(once[1].evidence.verdict, again[1].evidence.verdict);
  const Score score = CountTrials(once);
  EXPECT_EQ(score.good + score.broken + score.harmless, 2);
}

}  // namespace
}  // namespace waymark::evaluation

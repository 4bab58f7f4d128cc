// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/allowance.h"

#include <gtest/gtest.h>

namespace waymark {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const Allowance::Time kStart{seconds(1000)};

TEST(Allowance, HoldsWhatItSaysAndFillsAtItsRate) {
  Allowance allowance(2, 5, kStart);
  EXPECT_TRUE(allowance.IsFull(kStart));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(allowance.Take(1, kStart)) << i;
  EXPECT_FALSE(allowance.Take(1, kStart + milliseconds(499)));
  EXPECT_TRUE(allowance.Take(1, kStart + milliseconds(500)));
  EXPECT_FALSE(allowance.IsFull(kStart + milliseconds(2999)));
  EXPECT_TRUE(allowance.IsFull(kStart + milliseconds(3000)));
}

TEST(Allowance, HoldsTwoSecondsUnlessSaid) {
  Allowance allowance(3, kStart);
  EXPECT_TRUE(allowance.Take(6, kStart));
  EXPECT_FALSE(allowance.Take(0.1, kStart));
}

TEST(Allowance, NeverHoldsMore) {
  Allowance allowance(2, 5, kStart);
  EXPECT_FALSE(allowance.Take(5.5, kStart + seconds(3600)));
  EXPECT_TRUE(allowance.Take(5, kStart + seconds(3600)));
}

TEST(Allowance, WhatIsRefusedCostsNothing) {
  Allowance allowance(2, 5, kStart);
  EXPECT_FALSE(allowance.Take(6, kStart));
  EXPECT_TRUE(allowance.Take(5, kStart));
}

TEST(Allowance, AnEarlierTimeGivesNothing) {
  Allowance allowance(2, 5, kStart);
  EXPECT_TRUE(allowance.Take(5, kStart));
  EXPECT_FALSE(allowance.Take(1, kStart - seconds(10)));
  EXPECT_FALSE(allowance.Take(1, kStart)) << "nor does coming back from it";
}

}  // namespace
}  // namespace waymark

// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/parallel.h"

#include <gmock/gmock.h>

#include <vector>

namespace waymark {
namespace {

TEST(ParallelFor, VisitsEachIndexOnceOnAnyNumberOfThreads) {
  for (const int threads : {0, 1, 2, 7}) {
    std::vector<int> visits(1000, 0);
    ParallelFor(visits.size(), {.threads = threads}, [&](std::size_t i) { ++visits[i]; });
    EXPECT_THAT(visits, testing::Each(1)) << threads << " threads";
  }
}

TEST(ParallelFor, OfNothingReturns) {
  ParallelFor(0, {}, [](std::size_t) { FAIL(); });
}

}  // namespace
}  // namespace waymark

// SPDX-License-Identifier: Apache-2.0
// What every anchor store promises to many threads.
#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "tests/content_store/anchor_stores.h"

namespace waymark::content {
namespace {

TEST_P(AnchorThreads, OfManyThreadsOnOneRevisionExactlyOneWins) {
  AnchorRecord current = Applied(store_->Create(MakeAnchor(1)));
  for (int round = 0; round < 10; ++round) {
    std::atomic<int> wins = 0;
    std::vector<std::jthread> threads;
    for (int i = 0; i < 6; ++i) {
      threads.emplace_back([&, i] {
        AnchorRecord mine = current;
        mine.payload = fmt::format("round {} thread {}", round, i);
        const auto outcome = store_->Update(mine, current.revision);
        ASSERT_TRUE(outcome) << ToString(outcome.error());
        if (const auto* conflict = std::get_if<WriteConflict>(&*outcome)) {
          EXPECT_GT(conflict->current->revision, current.revision);
        } else {
          ++wins;
        }
      });
    }
    threads.clear();
    EXPECT_EQ(wins, 1);
    current = FindAnchor(current);
  }
  EXPECT_EQ(store_->LoadChanges(0, 100)->size(), 11u);
}

TEST_P(AnchorThreads, AReaderThatFollowsTheLogMissesNothing) {
  constexpr int kWriters = 4, kEach = 25;
  std::vector<std::jthread> writers;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&, w] {
      for (int i = 0; i < kEach; ++i) {
        Applied(store_->Create(MakeAnchor(static_cast<std::uint64_t>(1000 * w + i))));
      }
    });
  }
  const auto snapshot = store_->LoadRoom(kRoom);  // somewhere in the middle
  ASSERT_TRUE(snapshot);
  EXPECT_EQ(snapshot->anchors.size(), snapshot->revision) << "a picture at one revision";
  std::uint64_t seen = snapshot->revision;
  while (seen < kWriters * kEach) {
    const auto changes = store_->LoadChanges(seen, 7);
    ASSERT_TRUE(changes) << ToString(changes.error());
    for (const AnchorChange& change : *changes) {
      ASSERT_EQ(change.revision, seen + 1);
      seen = change.revision;
    }
  }
}

}  // namespace
}  // namespace waymark::content

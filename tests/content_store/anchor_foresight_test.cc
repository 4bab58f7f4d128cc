// SPDX-License-Identifier: Apache-2.0
// Creations that a store decides on what its last commit left, without asking the database first:
// every promise holds as if it had asked.
#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "tests/content_store/anchor_stores.h"

namespace waymark::content {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

AnchorRecord MakeOwned(std::uint64_t n) {
  AnchorRecord record = MakeAnchor(n);
  record.owner = "one owner";
  return record;
}

/// Two commits by one owner: the next creation of this owner is decided without asking.
void WarmUp(AnchorStore& store) {
  for (std::uint64_t n = 1001; n <= 1002; ++n) Applied(store.Create(MakeOwned(n)));
}

TEST_P(AnchorStores, AForeseenCreationMeetsWhatIsThere) {
  WarmUp(*store_);
  const AnchorRecord first = Applied(store_->Create(MakeOwned(1)));
  EXPECT_EQ(first.revision, 3u);
  EXPECT_EQ(Applied(store_->Create(MakeOwned(1))).revision, 3u) << "a retry";
  AnchorRecord other = MakeOwned(1);
  other.payload = "other";
  EXPECT_EQ(Conflict(store_->Create(other)).current->revision, 3u);
  Applied(store_->Delete(first.room, first.id, 3));
  Applied(store_->Create(MakeOwned(2)));
  EXPECT_FALSE(Conflict(store_->Create(MakeOwned(1))).current) << "its id stays spent";
  EXPECT_EQ(Applied(store_->Create(MakeOwned(3))).revision, 6u) << "refusals take no revision";
  EXPECT_EQ(store_->LoadChanges(0, 100)->size(), 6u);
}

TEST_P(AnchorStores, OneIdTwiceInAForeseenGroupIsSeen) {
  WarmUp(*store_);
  std::vector<AnchorRecord> records{MakeOwned(1), MakeOwned(1), MakeOwned(2)};
  records[1].payload = "other";
  const auto outcomes = store_->CreateMany(records);
  EXPECT_EQ(Applied(outcomes[0]).revision, 3u);
  EXPECT_EQ(Conflict(outcomes[1]).current->revision, 3u);
  EXPECT_EQ(Applied(outcomes[2]).revision, 4u);
}

TEST_P(AnchorLimits, ForeseenCreationsOfTwoServersShareOneLimit) {
  if (!GetParam().keeps) GTEST_SKIP() << "without limits";
  const StoreOptions options{.limits = {.max_anchors_per_owner = 20}};
  Open(options);
  auto other = GetParam().open(folder_.path(), options);
  ASSERT_TRUE(other) << ToString(other.error());
  WarmUp(*store_);
  std::uint64_t n = 0;
  for (const int in_a_row : {3, 1, 4, 1, 5}) {  // 14 more, each server in turn
    AnchorStore& server = n % 2 == 0 ? *store_ : **other;
    for (int i = 0; i < in_a_row; ++i) Applied(server.Create(MakeOwned(++n)));
  }
  for (int i = 0; i < 4; ++i) Applied(store_->Create(MakeOwned(++n)));
  for (AnchorStore* server : {store_.get(), other->get()}) {
    const auto refused = server->Create(MakeOwned(++n));
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr("holds its 20 anchors already"));
    EXPECT_EQ(Applied(server->Create(MakeOwned(1))).id, IdOf(1)) << "a retry is no new one";
  }
  EXPECT_EQ(store_->LoadRoom(kRoom)->anchors.size(), 20u);
  EXPECT_EQ(store_->LoadRoom(kRoom)->revision, 20u);
}

TEST_P(AnchorThreads, ForeseenCreationsOfTwoServersMakeOneSequence) {
  if (!GetParam().keeps) GTEST_SKIP() << "one process alone has it";
  auto other = GetParam().open(folder_.path(), {});
  ASSERT_TRUE(other) << ToString(other.error());
  constexpr std::uint64_t kEach = 40;
  std::vector<std::jthread> servers;
  for (AnchorStore* server : {store_.get(), other->get()}) {
    servers.emplace_back([&, server] {
      const std::uint64_t base = server == store_.get() ? 0 : 1000;
      for (std::uint64_t n = base; n < base + kEach; ++n) {
        Applied(server->Create(MakeOwned(n)));
        Applied(server->Create(MakeOwned(5000 + n - base)));  // whoever is first; a retry for one
      }
    });
  }
  servers.clear();
  const auto changes = store_->LoadChanges(0, 1000);
  ASSERT_TRUE(changes) << ToString(changes.error());
  EXPECT_EQ(changes->size(), 3 * kEach);
  EXPECT_EQ(changes->back().revision, 3 * kEach);
}

TEST_P(AnchorLimits, AWriteThatIsTriedAgainCountsOnce) {
  if (!GetParam().keeps) GTEST_SKIP() << "without limits";
  std::chrono::steady_clock::time_point now{};
  Open({.limits = {.max_writes_per_second = 1, .max_burst = 5}, .clock = [&] { return now; }});
  WarmUp(*store_);
  for (int i = 0; i < 10; ++i) Applied(store_->Create(MakeOwned(1001)));  // retries
  for (std::uint64_t n = 1; n <= 3; ++n) Applied(store_->Create(MakeOwned(n)));
  EXPECT_FALSE(store_->Create(MakeOwned(4)));
  now += 1s;
  Applied(store_->Create(MakeOwned(4)));
}

}  // namespace
}  // namespace waymark::content

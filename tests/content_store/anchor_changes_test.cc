// SPDX-License-Identifier: Apache-2.0
// What every anchor store promises about moves, expiry and its change feed.
#include <gmock/gmock.h>

#include <atomic>
#include <map>
#include <thread>

#include "tests/content_store/anchor_stores.h"

namespace waymark::content {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using namespace std::chrono_literals;

TEST_P(AnchorChanges, AMoveChangesThePlaceAlone) {
  AnchorRecord record = MakeAnchor(5);
  const AnchorRecord first = Applied(store_->Create(record));
  const AnchorRecord other = MakeAnchor(3);
  const AnchorMove move{.room = first.room,
                        .id = first.id,
                        .map_from_anchor = other.map_from_anchor,
                        .epoch = 7,
                        .attachments = other.attachments,
                        .place = other.place,
                        .changed_utc_ms = 99};
  record.map_from_anchor = move.map_from_anchor;
  record.epoch = 7;
  record.attachments = move.attachments;
  record.place = move.place;
  record.changed_utc_ms = 99;
  record.unsupported_since_epoch.reset();
  EXPECT_TRUE(SameAnchor(Applied(store_->Move(move, first.revision)), record));
  EXPECT_TRUE(SameAnchor(FindAnchor(record), record));
  EXPECT_TRUE(Conflict(store_->Move(move, first.revision)).current);
  AnchorMove invalid = move;
  invalid.epoch = 0;
  EXPECT_FALSE(store_->Move(invalid, 2));
}

TEST_P(AnchorChanges, AContentLinkIsKept) {
  AnchorRecord record = MakeAnchor(2);
  record.payload.clear();
  record.link = {"https://example.org/a.gltf", std::string(64, 'a')};
  Applied(store_->Create(record));
  EXPECT_TRUE(SameAnchor(FindAnchor(record), record));
  for (const PayloadLink& link :
       {PayloadLink{"no scheme", std::string(64, 'a')},
        PayloadLink{"https://x y", std::string(64, 'a')}, PayloadLink{"https://x", "short"},
        PayloadLink{"https://" + std::string(2048, 'x'), std::string(64, 'a')}}) {
    record.link = link;
    ExpectInvalid(record, "link");
  }
  record.link = {"https://example.org/a.gltf", std::string(64, 'a')};
  record.payload = "both";
  ExpectInvalid(record, "payload");
}

TEST_P(AnchorChanges, WhatHasExpiredGoesAndIsInTheFeed) {
  for (std::uint64_t n = 0; n < 20; ++n) Applied(store_->Create(MakeAnchor(n)));  // 4 expire
  EXPECT_EQ(store_->Expire(1'899'999'999'999, 100).value(), 0u);
  EXPECT_EQ(store_->Expire(1'900'000'000'009, 1).value(), 1u);
  EXPECT_EQ(store_->Expire(1'900'000'000'009, 100).value(), 1u);
  EXPECT_EQ(store_->Find(kRoom, IdOf(4)).value(), std::nullopt);
  EXPECT_EQ(store_->Find(kRoom, IdOf(9)).value(), std::nullopt);
  EXPECT_TRUE(store_->Find(kRoom, IdOf(14)).value());
  EXPECT_EQ(store_->LoadChanges(20, 100)->size(), 2u);
  EXPECT_EQ(store_->Expire(std::numeric_limits<std::int64_t>::max(), 100).value(), 2u);
}

TEST_P(AnchorChanges, ARoomsFeedHasItsChangesAlone) {
  for (std::uint64_t n = 0; n < 12; ++n) {
    Applied(store_->Create(MakeAnchor(n, n % 3 == 0 ? "room" : "other")));
  }
  const auto changes = store_->LoadRoomChanges(kRoom, 1, 2);
  ASSERT_TRUE(changes);
  ASSERT_EQ(changes->size(), 2u);
  EXPECT_EQ((*changes)[0].id, IdOf(3));
  EXPECT_EQ((*changes)[1].id, IdOf(6));
  EXPECT_THAT(store_->LoadRoomChanges(RoomId("nowhere"), 0, 10).value(), IsEmpty());
}

/// The state of a room built from a snapshot and what came after.
class Follower {
 public:
  Follower(AnchorStore& store, const RoomId& room) : store_(store), room_(room) {
    const auto snapshot = store.LoadRoom(room);
    seen_ = snapshot->revision;
    for (const AnchorRecord& record : snapshot->anchors) {
      EXPECT_LE(record.revision, seen_) << "a snapshot with the future in it";
      revisions_[record.id.text()] = record.revision;
    }
  }
  void FollowTo(std::uint64_t last) {
    while (seen_ < last) {
      const auto changes = store_.LoadRoomChanges(room_, seen_, 5);
      ASSERT_TRUE(changes) << ToString(changes.error());
      if (changes->empty()) break;
      for (const AnchorChange& change : *changes) {
        ASSERT_GT(change.revision, seen_) << "a change twice";
        seen_ = change.revision;
        revisions_.erase(change.id.text());
        if (change.record) revisions_[change.id.text()] = change.revision;
      }
    }
  }
  const std::map<std::string, std::uint64_t>& revisions() const { return revisions_; }

 private:
  AnchorStore& store_;
  const RoomId room_;
  std::uint64_t seen_ = 0;
  std::map<std::string, std::uint64_t> revisions_;
};

TEST_P(AnchorChanges, LateJoinersMeetEveryChangeOnce) {
  constexpr std::uint64_t kWriters = 3, kEach = 20;
  std::vector<std::jthread> writers;
  for (std::uint64_t w = 0; w < kWriters; ++w) {
    writers.emplace_back([&, w] {
      for (std::uint64_t i = 0; i < kEach; ++i) {
        AnchorRecord record = Applied(store_->Create(MakeAnchor(1000 * w + i)));
        record.payload = "again";
        record.link.reset();
        record = Applied(store_->Update(record, record.revision));
        if (i % 2 == 0) Applied(store_->Delete(record.room, record.id, record.revision));
      }
    });
  }
  std::vector<std::unique_ptr<Follower>> followers;
  for (int i = 0; i < 12; ++i) followers.push_back(std::make_unique<Follower>(*store_, kRoom));
  writers.clear();
  const std::uint64_t last = store_->LoadRoom(kRoom)->revision;
  EXPECT_EQ(last, kWriters * kEach * 5 / 2);
  const Follower truth(*store_, kRoom);
  EXPECT_EQ(truth.revisions().size(), kWriters * kEach / 2);
  for (const auto& follower : followers) {
    follower->FollowTo(last);
    EXPECT_EQ(follower->revisions(), truth.revisions());
  }
}

TEST_P(AnchorChanges, WhoWaitsIsWoken) {
  EXPECT_EQ(store_->WaitForChanges(0, 1ms).value(), 0u) << "nothing came";
  Applied(store_->Create(MakeAnchor(1)));
  EXPECT_EQ(store_->WaitForChanges(0, 1h).value(), 1u) << "it is there already";
  std::jthread writer([&] { Applied(store_->Create(MakeAnchor(2))); });
  EXPECT_EQ(store_->WaitForChanges(1, 1h).value(), 2u);
}

TEST_P(AnchorChanges, NoWriteComesBetweenLookingAndWaiting) {
  constexpr std::uint64_t kWrites = 150;
  std::jthread writer([&] {
    for (std::uint64_t n = 1; n <= kWrites; ++n) Applied(store_->Create(MakeAnchor(n)));
  });
  for (std::uint64_t seen = 0; seen < kWrites;) {
    const std::uint64_t latest = store_->WaitForChanges(seen, 1h).value();
    ASSERT_GT(latest, seen) << "woken for nothing";
    seen = latest;
  }
}

TEST_P(AnchorChanges, WhoWaitsHearsOfAnotherServersWrites) {
  if (!GetParam().keeps) GTEST_SKIP() << "one process alone has it";
  auto other = GetParam().open(folder_.path(), {});
  ASSERT_TRUE(other) << ToString(other.error());
  std::jthread writer([&] { Applied((*other)->Create(MakeAnchor(2))); });
  EXPECT_EQ(store_->WaitForChanges(0, 1h).value(), 1u);
  EXPECT_TRUE(SameAnchor(FindAnchor(MakeAnchor(2)), MakeAnchor(2)));
}

TEST_P(AnchorChanges, TwoServersWriteOneSequence) {
  if (!GetParam().keeps) GTEST_SKIP() << "one process alone has it";
  auto other = GetParam().open(folder_.path(), {});
  ASSERT_TRUE(other) << ToString(other.error());
  const AnchorRecord first = Applied(store_->Create(MakeAnchor(1)));
  std::atomic<int> wins = 0;
  std::vector<std::jthread> servers;
  for (AnchorStore* server : {store_.get(), other->get()}) {
    servers.emplace_back([&, server] {
      for (std::uint64_t i = 0; i < 30; ++i) {
        Applied(server->Create(MakeAnchor(100 + 2 * i + (server == store_.get() ? 0 : 1))));
      }
      const auto outcome = server->Update(first, first.revision);
      wins += outcome && std::holds_alternative<AnchorRecord>(*outcome) ? 1 : 0;
    });
  }
  servers.clear();
  EXPECT_EQ(wins, 1);
  const auto changes = store_->LoadChanges(0, 1000);
  ASSERT_TRUE(changes) << ToString(changes.error());
  EXPECT_EQ(changes->size(), 62u);
}

}  // namespace
}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
// What every anchor store promises about writes, its log and its rooms.
#include <gmock/gmock.h>

#include <limits>

#include "tests/content_store/anchor_stores.h"

namespace waymark::content {
namespace {

using testing::IsEmpty;

TEST_P(AnchorStores, EveryFieldComesBack) {
  for (std::uint64_t n = 0; n < 8; ++n) {
    const AnchorRecord wanted = MakeAnchor(n);
    const AnchorRecord stored = Applied(store_->Create(wanted));
    EXPECT_EQ(stored.revision, n + 1);
    EXPECT_TRUE(SameAnchor(stored, wanted));
    const AnchorRecord found = FindAnchor(wanted);
    EXPECT_TRUE(SameAnchor(found, wanted));
    EXPECT_EQ(found.revision, n + 1);
  }
}

TEST_P(AnchorStores, WhatIsNotThereIsNotFound) {
  Applied(store_->Create(MakeAnchor(1)));
  EXPECT_EQ(store_->Find(RoomId("other"), IdOf(1)).value(), std::nullopt);
  EXPECT_EQ(store_->Find(kRoom, IdOf(2)).value(), std::nullopt);
}

TEST_P(AnchorStores, ARepeatedCreationIsTheEarlierSuccess) {
  AnchorRecord record = MakeAnchor(3);
  const AnchorRecord first = Applied(store_->Create(record));
  record.created_utc_ms += 5;  // the server stamps the retry anew
  record.changed_utc_ms += 5;
  const AnchorRecord again = Applied(store_->Create(record));
  EXPECT_EQ(again.revision, first.revision);
  EXPECT_EQ(again.created_utc_ms, first.created_utc_ms);
  EXPECT_EQ(store_->LoadChanges(0, 100)->size(), 1u);
}

TEST_P(AnchorStores, ARepeatedCreationIsRecognisedAfterAnUpdate) {
  const AnchorRecord created = MakeAnchor(3);
  AnchorRecord moved = Applied(store_->Create(created));
  moved.payload = "moved on";
  Applied(store_->Update(moved, moved.revision));
  EXPECT_EQ(Applied(store_->Create(created)).payload, "moved on");
}

TEST_P(AnchorStores, ACreationWithOtherContentMeetsTheCurrentRecord) {
  const AnchorRecord first = Applied(store_->Create(MakeAnchor(3)));
  AnchorRecord other = MakeAnchor(3);
  other.payload = "other";
  const WriteConflict conflict = Conflict(store_->Create(other));
  ASSERT_TRUE(conflict.current);
  EXPECT_TRUE(SameAnchor(*conflict.current, first));
  EXPECT_EQ(conflict.current->revision, first.revision);
}

TEST_P(AnchorStores, AnIdMayServeInTwoRooms) {
  Applied(store_->Create(MakeAnchor(3, "a")));
  EXPECT_EQ(Applied(store_->Create(MakeAnchor(3, "b"))).revision, 2u);
}

TEST_P(AnchorStores, AnUpdateReplacesContentAndKeepsOrigin) {
  const AnchorRecord first = Applied(store_->Create(MakeAnchor(5)));
  AnchorRecord next = MakeAnchor(6);
  next.id = first.id;
  const AnchorRecord stored = Applied(store_->Update(next, first.revision));
  next.owner = first.owner;
  next.created_utc_ms = first.created_utc_ms;
  EXPECT_TRUE(SameAnchor(stored, next));
  EXPECT_TRUE(SameAnchor(FindAnchor(next), next));
  EXPECT_EQ(stored.revision, 2u);
}

TEST_P(AnchorStores, AnOutdatedUpdateMeetsTheCurrentRecord) {
  const AnchorRecord first = Applied(store_->Create(MakeAnchor(5)));
  AnchorRecord mine = first, theirs = first;
  theirs.payload = "theirs";
  mine.payload = "mine";
  Applied(store_->Update(theirs, first.revision));
  const WriteConflict conflict = Conflict(store_->Update(mine, first.revision));
  ASSERT_TRUE(conflict.current);
  EXPECT_EQ(conflict.current->payload, "theirs");
  EXPECT_EQ(conflict.current->revision, 2u);
  EXPECT_EQ(FindAnchor(first).payload, "theirs");
  EXPECT_TRUE(Conflict(store_->Update(mine, std::numeric_limits<std::uint64_t>::max())).current);
}

TEST_P(AnchorStores, AnUpdateOfNothingIsAConflictWithNothing) {
  EXPECT_FALSE(Conflict(store_->Update(MakeAnchor(1), 0)).current);
  EXPECT_FALSE(Conflict(store_->Delete(kRoom, IdOf(1), 0)).current);
}

TEST_P(AnchorStores, ADeletedAnchorIsGoneAndItsIdStaysSpent) {
  const AnchorRecord first = Applied(store_->Create(MakeAnchor(5)));
  const auto outdated = Conflict(store_->Delete(kRoom, first.id, first.revision + 1));
  EXPECT_TRUE(outdated.current);
  const AnchorRecord last = Applied(store_->Delete(kRoom, first.id, first.revision));
  EXPECT_EQ(last.revision, 2u);
  EXPECT_TRUE(SameAnchor(last, first));
  EXPECT_EQ(store_->Find(kRoom, first.id).value(), std::nullopt);
  EXPECT_THAT(store_->LoadRoom(kRoom)->anchors, IsEmpty());
  EXPECT_THAT(Near(first.place, 10), IsEmpty());
  EXPECT_FALSE(Conflict(store_->Delete(kRoom, first.id, last.revision)).current);
  EXPECT_FALSE(Conflict(store_->Update(first, last.revision)).current);
  EXPECT_FALSE(Conflict(store_->Create(MakeAnchor(5))).current)
      << "a late retry must not revive it";
}

TEST_P(AnchorStores, TheChangeLogHasEveryWriteInOrder) {
  AnchorRecord a = Applied(store_->Create(MakeAnchor(1, "a")));
  const AnchorRecord b = Applied(store_->Create(MakeAnchor(2, "b")));
  a.payload = "changed";
  Applied(store_->Update(a, a.revision));
  Applied(store_->Delete(b.room, b.id, b.revision));
  const auto changes = store_->LoadChanges(0, 100);
  ASSERT_TRUE(changes);
  ASSERT_EQ(changes->size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ((*changes)[i].revision, i + 1);
  EXPECT_EQ((*changes)[0].record->payload, MakeAnchor(1).payload);
  EXPECT_EQ((*changes)[2].record->payload, "changed");
  EXPECT_EQ((*changes)[3].record, std::nullopt);
  EXPECT_EQ((*changes)[3].id, b.id);
  EXPECT_EQ((*changes)[3].room, b.room);

  const auto page = store_->LoadChanges(1, 2);
  ASSERT_EQ(page->size(), 2u);
  EXPECT_EQ(page->front().revision, 2u);
  EXPECT_THAT(store_->LoadChanges(4, 100).value(), IsEmpty());
  constexpr auto kHuge = std::numeric_limits<std::uint64_t>::max();
  EXPECT_THAT(store_->LoadChanges(kHuge, kHuge).value(), IsEmpty());
  EXPECT_EQ(store_->LoadChanges(0, kHuge)->size(), 4u);
}

TEST_P(AnchorStores, ARoomIsLoadedSortedAndAtARevision) {
  for (const std::uint64_t n : {7, 3, 9}) Applied(store_->Create(MakeAnchor(n)));
  Applied(store_->Create(MakeAnchor(1, "other")));
  const auto snapshot = store_->LoadRoom(kRoom);
  ASSERT_TRUE(snapshot);
  EXPECT_EQ(snapshot->revision, 4u);
  ASSERT_EQ(snapshot->anchors.size(), 3u);
  EXPECT_LT(snapshot->anchors[0].id, snapshot->anchors[1].id);
  EXPECT_LT(snapshot->anchors[1].id, snapshot->anchors[2].id);
  EXPECT_THAT(store_->LoadRoom(RoomId("nowhere"))->anchors, IsEmpty());
}

TEST_P(AnchorStores, RoomsAreListedWithTheirLatestChange) {
  Applied(store_->Create(MakeAnchor(1, "b")));
  const AnchorRecord gone = Applied(store_->Create(MakeAnchor(1, "a")));
  Applied(store_->Create(MakeAnchor(2, "b")));
  Applied(store_->Delete(gone.room, gone.id, gone.revision));
  const auto rooms = store_->ListRooms();
  ASSERT_EQ(rooms->size(), 2u);
  EXPECT_EQ((*rooms)[0].room, RoomId("a"));
  EXPECT_EQ((*rooms)[0].anchors, 0u);
  EXPECT_EQ((*rooms)[0].revision, 4u);
  EXPECT_EQ((*rooms)[1].anchors, 2u);
  EXPECT_EQ((*rooms)[1].revision, 3u);
}

}  // namespace
}  // namespace waymark::content

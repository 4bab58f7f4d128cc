// SPDX-License-Identifier: Apache-2.0
// What every anchor store promises, run on each of them.
#include "content_store/anchor_store.h"

#include <gmock/gmock.h>

#include <atomic>
#include <limits>
#include <memory>
#include <thread>

#include "content_store/anchor_rules.h"
#include "tests/content_store/anchor_fixtures.h"
#include "tests/support/memory_anchor_store.h"

namespace waymark::content {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

enum class Backend { kMemory, kSqlite };

class AnchorStores : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    if (GetParam() == Backend::kMemory) {
      store_ = std::make_unique<support::MemoryAnchorStore>();
      return;
    }
    auto store = OpenSqliteStore(folder_.path() / "anchors.db");
    ASSERT_TRUE(store) << ToString(store.error());
    store_ = *std::move(store);
  }

  AnchorRecord FindAnchor(const AnchorRecord& wanted) {
    const auto found = store_->Find(wanted.room, wanted.id);
    if (found && *found) return **found;
    ADD_FAILURE() << (found ? "not there" : ToString(found.error()));
    return MakeAnchor(0);
  }
  std::vector<std::string> Near(const GeoPoint& centre, double radius_m, std::size_t limit = 100) {
    const auto found = store_->FindNear(kRoom, centre, radius_m, limit);
    if (!found) return {ToString(found.error())};
    std::vector<std::string> ids;
    for (const AnchorRecord& record : *found) ids.push_back(record.id.text());
    return ids;
  }
  void ExpectInvalid(const AnchorRecord& record, const std::string& field) {
    const auto outcome = store_->Create(record);
    ASSERT_FALSE(outcome) << field;
    EXPECT_EQ(outcome.error().code, ErrorCode::kInvalidArgument) << field;
    EXPECT_THAT(outcome.error().message, HasSubstr(field));
    EXPECT_FALSE(store_->Update(record, 1));
  }

  const RoomId kRoom{"room"};
  TemporaryFolder folder_;
  std::unique_ptr<AnchorStore> store_;
};

INSTANTIATE_TEST_SUITE_P(All, AnchorStores, testing::Values(Backend::kMemory, Backend::kSqlite),
                         [](const auto& backend) {
                           return backend.param == Backend::kMemory ? "Memory" : "Sqlite";
                         });

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

TEST_P(AnchorStores, NeighboursComeNearestFirst) {
  const GeoPoint centre = PlaceAt(47.37, 8.54);
  const TangentPlane plane(centre);
  for (std::uint64_t n = 1; n <= 5; ++n) {
    AnchorRecord record = MakeAnchor(n);
    record.place = plane.ToGeo(Point<Map>(0, 20.0 * static_cast<double>(6 - n), 5));
    Applied(store_->Create(record));
  }
  AnchorRecord elsewhere = MakeAnchor(6, "other");
  elsewhere.place = centre;
  Applied(store_->Create(elsewhere));
  EXPECT_THAT(Near(centre, 61), ElementsAre(IdOf(5).text(), IdOf(4).text(), IdOf(3).text()));
  EXPECT_THAT(Near(centre, 1000, 2), ElementsAre(IdOf(5).text(), IdOf(4).text()));
  EXPECT_THAT(Near(centre, 10), IsEmpty());
  EXPECT_THAT(Near(centre, 1000, 0), IsEmpty());
  EXPECT_EQ(Near(centre, 3e7).size(), 5u) << "a circle around the earth";
}

TEST_P(AnchorStores, EquallyNearOnesAreOrderedById) {
  for (const std::uint64_t n : {4, 2, 3, 1}) {
    AnchorRecord record = MakeAnchor(n);
    record.place = PlaceAt(10, 10);
    Applied(store_->Create(record));
  }
  EXPECT_THAT(Near(PlaceAt(10, 10), 0),
              ElementsAre(IdOf(1).text(), IdOf(2).text(), IdOf(3).text(), IdOf(4).text()));
  EXPECT_THAT(Near(PlaceAt(10, 10), 1, 2), ElementsAre(IdOf(1).text(), IdOf(2).text()));
}

TEST_P(AnchorStores, NeighboursAreFoundAcrossTheDateLineAndAtThePoles) {
  AnchorRecord east = MakeAnchor(1), west = MakeAnchor(2), north = MakeAnchor(3);
  east.place = PlaceAt(-17, 179.9999);
  west.place = PlaceAt(-17, -179.9999);
  north.place = PlaceAt(90, 12);
  for (const auto& record : {east, west, north}) Applied(store_->Create(record));
  EXPECT_THAT(Near(PlaceAt(-17, 180), 20),
              testing::UnorderedElementsAre(IdOf(1).text(), IdOf(2).text()));
  EXPECT_THAT(Near(PlaceAt(89.9999, -170), 20), ElementsAre(IdOf(3).text()));
}

TEST_P(AnchorStores, AnUpdateMovesAnAnchorInSpace) {
  AnchorRecord record = Applied(store_->Create(MakeAnchor(1)));
  const GeoPoint before = record.place;
  record.place = PlaceAt(-33.9, 151.2);
  Applied(store_->Update(record, record.revision));
  EXPECT_THAT(Near(before, 100), IsEmpty());
  EXPECT_THAT(Near(record.place, 1), ElementsAre(record.id.text()));
}

TEST_P(AnchorStores, ImpossibleQueriesAreRefused) {
  EXPECT_THAT(Near(PlaceAt(91, 0), 10), ElementsAre(HasSubstr("latitude")));
  for (const double radius_m : {-1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THAT(Near(PlaceAt(0, 0), radius_m), ElementsAre(HasSubstr("radius")));
  }
}

TEST_P(AnchorStores, ValuesBeyondTheirLimitsAreRefused) {
  const auto with = [](auto change) {
    AnchorRecord record = MakeAnchor(3);
    change(record);
    return record;
  };
  using R = AnchorRecord&;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const char* id :
       {"", "3", "0000000G-0000-4000-8000-000000000003", "0000000A-0000-4000-8000-000000000003",
        "00000003-0000-4000-8000-0000000000031", "00000003000004000080000000000000000003",
        "../../../etc/passwd"}) {
    ExpectInvalid(with([&](R r) { r.id = AnchorId(id); }), "UUID");
  }
  ExpectInvalid(with([](R r) { r.room = RoomId(""); }), "room");
  ExpectInvalid(with([](R r) { r.room = RoomId(std::string(256, 'r')); }), "room");
  ExpectInvalid(with([](R r) { r.owner = std::string(256, 'o'); }), "owner");
  ExpectInvalid(with([](R r) { r.kind = std::string(256, 'k'); }), "kind");
  ExpectInvalid(with([](R r) { r.payload = std::string(kMaxPayloadBytes + 1, 'p'); }), "payload");
  ExpectInvalid(with([](R r) { r.epoch = 0; }), "epoch");
  ExpectInvalid(with([](R r) { r.place.latitude = Angle::Degrees(90.1); }), "place");
  ExpectInvalid(with([](R r) { r.place.ellipsoid_height_m = kNan; }), "place");
  ExpectInvalid(with([](R r) { r.attachments.push_back(r.attachments.front()); }), "attachments");
  ExpectInvalid(with([](R r) { r.attachments[1].submap = SubmapId("a b"); }), "submap");
  const auto pose = []<typename To>(Transform<To, Anchor>& out, double w, double x_m) {
    out = Transform<To, Anchor>(Eigen::Quaterniond(w, 0, 0, 0), Eigen::Vector3d(x_m, 0, 0));
  };
  ExpectInvalid(with([&](R r) { pose(r.map_from_anchor, 1, kNan); }), "map_from_anchor");
  ExpectInvalid(with([&](R r) { pose(r.map_from_anchor, 0, 0); }), "quaternion");
  ExpectInvalid(with([&](R r) { pose(r.attachments[0].submap_from_anchor, kNan, 0); }),
                "attachment");
  EXPECT_EQ(store_->LoadRoom(kRoom)->revision, 0u) << "nothing was written";
}

TEST_P(AnchorStores, TheLargestRecordFits) {
  AnchorRecord record = MakeAnchor(3, std::string(255, 'r'));
  record.owner = std::string(255, 'o');
  record.kind = std::string(255, 'k');
  record.payload = std::string(kMaxPayloadBytes, '\xff');
  record.epoch = std::numeric_limits<std::uint64_t>::max();
  record.created_utc_ms = std::numeric_limits<std::int64_t>::min();
  Applied(store_->Create(record));
  EXPECT_TRUE(SameAnchor(FindAnchor(record), record));
}

TEST_P(AnchorStores, HostileTextIsOnlyText) {
  const std::string injection = "'); DROP TABLE anchors; --";
  AnchorRecord record = MakeAnchor(1, injection);
  record.owner = record.kind = injection;
  record.payload = injection + std::string("\0\xff\xfe \0", 5);
  Applied(store_->Create(record));
  EXPECT_TRUE(SameAnchor(FindAnchor(record), record));
  EXPECT_EQ(store_->LoadRoom(record.room)->anchors.size(), 1u);
  EXPECT_EQ(store_->ListRooms()->front().room.text(), injection);
  EXPECT_EQ(store_->Find(RoomId("' OR '1'='1"), record.id).value(), std::nullopt);
  EXPECT_EQ(store_->Find(record.room, AnchorId("' OR '1'='1")).value(), std::nullopt);
  EXPECT_FALSE(Conflict(store_->Delete(RoomId(std::string("a\0b", 3)), record.id, 1)).current);
}

TEST_P(AnchorStores, NamesAreWellFormedUtf8) {
  for (const std::string& text :
       {std::string("a\0b", 3), std::string("\xff"), std::string("\xc0\xaf"),
        std::string("\xed\xa0\x80"), std::string("\xe2\x82"), std::string("\xf4\x90\x80\x80"),
        std::string("\xf0\x8f\xbf\xbf"), std::string("\x80")}) {
    AnchorRecord record = MakeAnchor(1);
    record.kind = text;
    ExpectInvalid(record, "UTF-8");
    EXPECT_EQ(store_->Find(RoomId(text), record.id).value(), std::nullopt);
  }
  AnchorRecord record = MakeAnchor(1, "Zürich – 東京 🚏");
  Applied(store_->Create(record));
  EXPECT_TRUE(SameAnchor(FindAnchor(record), record));
}

TEST_P(AnchorStores, OfManyThreadsOnOneRevisionExactlyOneWins) {
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

TEST_P(AnchorStores, AReaderThatFollowsTheLogMissesNothing) {
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

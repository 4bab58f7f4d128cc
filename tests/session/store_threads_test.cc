// SPDX-License-Identifier: Apache-2.0
// What a server does with its store by itself: follows it, and looks after what is in it.
#include <gmock/gmock.h>

#include "session/server/anchor_keeper.h"
#include "session/server/store_follower.h"
#include "session/wire/inbox.h"
#include "tests/session/session_fixture.h"
#include "tests/support/memory_anchor_store.h"

namespace waymark::session {
namespace {

using support::Eventually;
using testing::ElementsAre;
using waymark::support::MemoryAnchorStore;

content::AnchorRecord Anchor(int number, const std::string& room = "square") {
  content::AnchorRecord record{
      .id = AnchorId(FormatUuid(UuidFromBits(1, static_cast<std::uint64_t>(number)))),
      .room = RoomId(room)};
  record.place = support::MapOrigin();
  return record;
}

// ---- following --------------------------------------------------------------------------------

/// A store whose state of revision 3 is damaged, and which is away for a while.
class FailingStore : public MemoryAnchorStore {
 public:
  Result<std::vector<content::AnchorChange>> LoadChanges(std::uint64_t after,
                                                         std::size_t limit) override {
    if (after < 3 && after + limit >= 3) return MakeError(ErrorCode::kCorrupt, "revision 3");
    return MemoryAnchorStore::LoadChanges(after, limit);
  }
  Result<std::uint64_t> WaitForChanges(std::uint64_t after,
                                       std::chrono::milliseconds timeout) override {
    if (is_away) return MakeError(ErrorCode::kUnavailable, "away");
    return MemoryAnchorStore::WaitForChanges(after, timeout);
  }

  std::atomic<bool> is_away = false;
};

class Follower : public testing::Test {
 protected:
  std::vector<std::uint64_t> Told(std::size_t count) {
    while (told_.size() < count) {
      const auto some = inbox_.TakeAll(std::chrono::steady_clock::now() + std::chrono::minutes(1));
      if (some.empty()) break;
      for (const event::StoreChanged& event : some) {
        for (const content::AnchorChange& change : event.changes) told_.push_back(change.revision);
      }
    }
    return told_;
  }
  std::function<void(event::StoreChanged)> Report() {
    return [this](event::StoreChanged event) { inbox_.Push(std::move(event)); };
  }

  Inbox<event::StoreChanged> inbox_{100, 100};
  std::vector<std::uint64_t> told_;
};

TEST_F(Follower, TellsWhatComesFromNowOn) {
  MemoryAnchorStore store;
  ASSERT_TRUE(store.Create(Anchor(1)));
  StoreFollower follower(store, Report());
  ASSERT_TRUE(store.Create(Anchor(2)));
  ASSERT_TRUE(store.Delete(RoomId("square"), Anchor(1).id, 1));
  EXPECT_THAT(Told(2), ElementsAre(2, 3));
  follower.Finish();
  ASSERT_TRUE(store.Create(Anchor(3)));
  EXPECT_THAT(inbox_.TakeAll({}), testing::IsEmpty()) << "it has ended";
}

TEST_F(Follower, OneDamagedStateDoesNotHideTheOthers) {
  FailingStore store;
  const StoreFollower follower(store, Report());
  for (int n = 1; n <= 5; ++n) ASSERT_TRUE(store.Create(Anchor(n)));
  EXPECT_THAT(Told(4), ElementsAre(1, 2, 4, 5));
}

TEST_F(Follower, AStoreThatWasAwayIsFollowedOn) {
  FailingStore store;
  store.is_away = true;
  const StoreFollower follower(store, Report());
  ASSERT_TRUE(store.Create(Anchor(1)));
  ASSERT_TRUE(store.Create(Anchor(2)));
  store.is_away = false;
  EXPECT_THAT(Told(2), ElementsAre(1, 2));
}

// ---- looking after ----------------------------------------------------------------------------

std::shared_ptr<const LiveRelease> Live(std::uint64_t epoch, const std::string& submaps) {
  mapping::Release release;
  release.epoch = epoch;
  for (const char letter : submaps) {
    release.submaps.push_back({.id = SubmapId(std::string(1, letter)),
                               .map_from_submap = Similarity<Map, Submap>(
                                   Sim3(1, Eigen::Quaterniond::Identity(), {1.0 * letter, 0, 0})),
                               .centre = Point<Map>(0, 0, 0),
                               .radius_m = 50,
                               .displacement = std::nullopt});
  }
  return std::make_shared<const LiveRelease>(std::move(release));
}

std::string Submaps(MemoryAnchorStore& store, const content::AnchorRecord& anchor) {
  const auto found = store.Find(anchor.room, anchor.id);
  std::string submaps;
  for (const auto& attachment : (*found)->attachments) submaps += attachment.submap.text();
  return submaps;
}

TEST(AnchorKeeper, RenewsTheAnchorsOfAllRoomsAfterEachRelease) {
  MemoryAnchorStore store;
  const TangentPlane plane(support::MapOrigin());
  auto live = Live(1, "ab");
  std::vector<content::AnchorRecord> anchors{Anchor(1, "square"), Anchor(2, "park")};
  for (content::AnchorRecord& anchor : anchors) {
    anchor.attachments = AttachToSubmaps(anchor.map_from_anchor, {}, live->release);
    ASSERT_TRUE(store.Create(anchor));
  }
  AnchorKeeper keeper(store, plane, live);
  keeper.SetRelease(Live(2, "bcd"));
  for (const content::AnchorRecord& anchor : anchors) {
    EXPECT_TRUE(Eventually([&] { return Submaps(store, anchor) == "bcd"; }));
  }
  keeper.SetRelease(Live(3, "de"));
  for (const content::AnchorRecord& anchor : anchors) {
    EXPECT_TRUE(Eventually([&] { return Submaps(store, anchor).starts_with("de"); }));
  }
  keeper.Finish();
}

TEST(AnchorKeeper, LooksAfterWhatIsThereWhenItBegins) {
  MemoryAnchorStore store;
  content::AnchorRecord anchor = Anchor(1);
  anchor.attachments = AttachToSubmaps(anchor.map_from_anchor, {}, Live(1, "abc")->release);
  ASSERT_TRUE(store.Create(anchor));
  const AnchorKeeper keeper(store, TangentPlane(support::MapOrigin()), Live(4, "cxy"));
  EXPECT_TRUE(Eventually([&] { return Submaps(store, anchor) == "cxy"; }));
}

TEST(AnchorKeeper, DeletesWhatHasExpiredAndNothingElse) {
  MemoryAnchorStore store;
  content::AnchorRecord over = Anchor(1), lasting = Anchor(2);
  over.expires_utc_ms = 1'700'000'000'000;
  lasting.expires_utc_ms = 95'617'584'000'000;
  for (const auto& record : {over, lasting, Anchor(3)}) ASSERT_TRUE(store.Create(record));
  const AnchorKeeper keeper(store, TangentPlane(support::MapOrigin()), Live(1, "a"));
  EXPECT_TRUE(Eventually([&] { return store.LoadRoom(over.room)->anchors.size() == 2; }));
  EXPECT_FALSE(*store.Find(over.room, over.id));
}

}  // namespace
}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
// The parts of a server that need no network: inbox, localisation queue, attachments.
#include <gmock/gmock.h>

#include <future>

#include "session/server/attachments.h"
#include "session/server/localise_pool.h"
#include "session/state/carrying.h"
#include "session/wire/inbox.h"
#include "tests/support/localise_query.h"
#include "tests/support/random_geometry.h"

namespace waymark::session {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using waymark::support::Near;
using waymark::support::RandomGeometry;

// ---- inbox ------------------------------------------------------------------------------------

TEST(Inbox, IsBoundedForOthersButNotForOurselves) {
  Inbox<int> inbox(2, 10);
  EXPECT_TRUE(inbox.TryPush(1, 0));
  EXPECT_FALSE(inbox.TryPush(2, 11)) << "too heavy";
  EXPECT_TRUE(inbox.TryPush(3, 10));
  EXPECT_FALSE(inbox.TryPush(4, 0)) << "too many";
  inbox.Push(5);
  EXPECT_THAT(inbox.TakeAll({}), ElementsAre(1, 3, 5));
  EXPECT_EQ(inbox.DroppedItems(), 2u);
  EXPECT_TRUE(inbox.TryPush(6, 10)) << "taking makes room";
}

TEST(Inbox, ClosingEndsTheWait) {
  Inbox<int> inbox(2, 10);
  inbox.Close();
  EXPECT_THAT(inbox.TakeAll(std::chrono::steady_clock::time_point::max()), IsEmpty());
}

// ---- localisation queue -----------------------------------------------------------------------

/// Collects answers.
class Pool : public testing::Test {
 protected:
  void AwaitEntry() {
    entered_.TakeAll(std::chrono::steady_clock::now() + std::chrono::minutes(1));
  }
  void Deliver(LocaliseAnswer answer) { answers_.Push(std::move(answer)); }
  std::vector<LocaliseAnswer> Answers(std::size_t count) {
    std::vector<LocaliseAnswer> all;
    while (all.size() < count) {
      auto some = answers_.TakeAll(std::chrono::steady_clock::now() + std::chrono::minutes(1));
      if (some.empty()) break;
      for (LocaliseAnswer& answer : some) all.push_back(std::move(answer));
    }
    return all;
  }

  const DeviceId anna_{"a"}, ben_{"b"}, cleo_{"c"}, dora_{"d"};
  Inbox<RequestNumber> entered_{100, 100};
  Inbox<LocaliseAnswer> answers_{100, 100};
};

TEST_F(Pool, TheNewestImageOfADeviceWinsAndAFullQueueSaysBusy) {
  std::promise<void> gate;
  const std::shared_future<void> open(gate.get_future());
  LocalisePool pool(
      {.threads = 1, .max_queue = 2, .max_wait = std::chrono::hours(1)},
      [&](const LocaliseQuery& query) -> Result<localiser::Localisation> {
        entered_.Push(query.request);
        open.wait();
        return localiser::Localisation{};
      },
      [this](LocaliseAnswer answer) { Deliver(std::move(answer)); });
  pool.Submit(anna_, support::TinyQuery(1));
  AwaitEntry();
  pool.Submit(ben_, support::TinyQuery(2));
  pool.Submit(cleo_, support::TinyQuery(3));
  pool.Submit(ben_, support::TinyQuery(4));   // takes the place of 2
  pool.Submit(dora_, support::TinyQuery(5));  // no place left
  const auto refused = Answers(2);
  ASSERT_THAT(refused, SizeIs(2));
  EXPECT_EQ(refused[0].request, RequestNumber{2});
  EXPECT_EQ(refused[0].device, ben_);
  EXPECT_EQ(refused[0].status, LocaliseStatus::kBusy);
  EXPECT_EQ(refused[1].request, RequestNumber{5});
  EXPECT_EQ(refused[1].device, dora_);
  gate.set_value();
  const auto answered = Answers(3);
  ASSERT_THAT(answered, SizeIs(3));
  EXPECT_EQ(answered[0].request, RequestNumber{1});
  EXPECT_EQ(answered[1].request, RequestNumber{4}) << "it kept the place of the older one";
  EXPECT_EQ(answered[2].request, RequestNumber{3});
}

TEST_F(Pool, AnImageThatWaitedTooLongIsNotLookedAt) {
  LocalisePool pool(
      {.max_wait = std::chrono::duration<double>(0)},
      [&](const LocaliseQuery& query) -> Result<localiser::Localisation> {
        entered_.Push(query.request);
        return localiser::Localisation{};
      },
      [this](LocaliseAnswer answer) { Deliver(std::move(answer)); });
  pool.Submit(anna_, support::TinyQuery(1));
  const auto answers = Answers(1);
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_EQ(answers[0].status, LocaliseStatus::kBusy);
  EXPECT_THAT(answers[0].reason, testing::HasSubstr("waited"));
  EXPECT_THAT(entered_.TakeAll({}), IsEmpty());
}

TEST_F(Pool, AnImageThatIsNoneIsTheDevicesFault) {
  LocalisePool pool(
      {},
      [](const LocaliseQuery&) -> Result<localiser::Localisation> {
        return MakeError(ErrorCode::kCorrupt, "no JPEG");
      },
      [this](LocaliseAnswer answer) { Deliver(std::move(answer)); });
  pool.Submit(anna_, support::TinyQuery(1));
  const auto answers = Answers(1);
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_EQ(answers[0].status, LocaliseStatus::kInvalidImage);
  EXPECT_THAT(answers[0].reason, testing::HasSubstr("no JPEG"));
}

// ---- attachments ------------------------------------------------------------------------------

mapping::ReleasedSubmap Submap(const std::string& id, double centre_x_m, const Sim3& sim) {
  return {.id = SubmapId(id),
          .map_from_submap = Similarity<Map, waymark::Submap>(sim),
          .centre = Point<Map>(centre_x_m, 0, 0),
          .radius_m = 20,
          .displacement = std::nullopt};
}

mapping::Release MakeRelease(std::uint64_t epoch, RandomGeometry& random) {
  mapping::Release release;
  release.epoch = epoch;
  int x = 0;
  for (const char* id : {"a", "b", "c", "d", "far"}) {
    release.submaps.push_back(Submap(id, x, random.Similarity()));
    x += x == 90 ? 900 : 30;
  }
  return release;
}

std::vector<std::string> Ids(const std::vector<content::SubmapAttachment>& attachments) {
  std::vector<std::string> ids;
  for (const auto& attachment : attachments) ids.push_back(attachment.submap.text());
  return ids;
}

TEST(Attachments, AreToWhereItWasSeenThenToTheNearest) {
  RandomGeometry random(1);
  const mapping::Release release = MakeRelease(1, random);
  const Transform<Map, Anchor> map_from_anchor(random.Rotation(), {1, 2, 3});
  const std::vector<SubmapId> seen{SubmapId("c"), SubmapId("unknown"), SubmapId("c")};
  const auto attachments = AttachToSubmaps(map_from_anchor, seen, release);
  EXPECT_THAT(Ids(attachments), ElementsAre("c", "a", "b"));
  for (const auto& attachment : attachments) {
    const auto submap = std::find_if(release.submaps.begin(), release.submaps.end(),
                                     [&](const auto& s) { return s.id == attachment.submap; });
    EXPECT_THAT(CarryPose(submap->map_from_submap, attachment.submap_from_anchor).rigid(),
                Near(map_from_anchor.rigid()));
  }
}

TEST(Attachments, AreNotToWhatIsFarAway) {
  RandomGeometry random(2);
  const mapping::Release release = MakeRelease(1, random);
  EXPECT_THAT(AttachToSubmaps({Eigen::Quaterniond::Identity(), {500, 0, 0}}, {}, release),
              IsEmpty());
}

TEST(Attachments, CarryTheAnchorExactlyToTheNextRelease) {
  RandomGeometry random(3);
  const mapping::Release before = MakeRelease(1, random);
  mapping::Release after = MakeRelease(2, random);
  content::AnchorRecord record{.id = AnchorId("x"), .room = RoomId("r")};
  record.map_from_anchor = {random.Rotation(), {1, 2, 3}};
  record.attachments = AttachToSubmaps(record.map_from_anchor, {}, before);
  ASSERT_THAT(Ids(record.attachments), ElementsAre("a", "b", "c"));

  const RoomAnchor same = CarryAnchor(record, before.epoch, PlacementsOf(before));
  EXPECT_TRUE(same.is_supported);
  EXPECT_THAT(same.record.map_from_anchor.rigid(), Near(record.map_from_anchor.rigid()));

  after.submaps.erase(after.submaps.begin());  // "a" is gone: "b" carries it
  const RoomAnchor carried = CarryAnchor(record, after.epoch, PlacementsOf(after));
  EXPECT_TRUE(carried.is_supported);
  EXPECT_EQ(carried.record.epoch, 2u);
  EXPECT_THAT(
      carried.record.map_from_anchor.rigid(),
      Near(CarryPose(after.submaps[0].map_from_submap, record.attachments[1].submap_from_anchor)
               .rigid()));

  after.submaps.erase(after.submaps.begin(), after.submaps.begin() + 2);
  const RoomAnchor orphan = CarryAnchor(record, after.epoch, PlacementsOf(after));
  EXPECT_FALSE(orphan.is_supported);
  EXPECT_THAT(orphan.record.map_from_anchor.rigid(), Near(record.map_from_anchor.rigid()))
      << "it is not moved by guesswork";
}

}  // namespace
}  // namespace waymark::session

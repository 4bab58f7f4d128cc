// SPDX-License-Identifier: Apache-2.0
// What every anchor store promises about questions by place, by time and by room.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "content_store/anchor_rules.h"
#include "tests/content_store/anchor_stores.h"

namespace waymark::content {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAreArray;

std::vector<std::string> IdsOf(const std::vector<AnchorRecord>& records) {
  std::vector<std::string> ids;
  for (const AnchorRecord& record : records) ids.push_back(record.id.text());
  return ids;
}

GeoBox Box(double south, double west, double north, double east) {
  return {Angle::Degrees(south), Angle::Degrees(west), Angle::Degrees(north), Angle::Degrees(east)};
}

TEST_P(AnchorQueries, AreThoseOfAnExhaustiveSearch) {
  std::vector<AnchorRecord> all;
  support::RandomGeometry random(5);
  for (std::uint64_t n = 0; n < 150; ++n) {
    all.push_back(Applied(store_->Create(MakeAnchor(n, n % 4 == 0 ? "other" : "room"))));
  }
  for (int trial = 0; trial < 30; ++trial) {
    AnchorQuery query{.room = kRoom, .limit = 1 + std::size_t(trial) * 3};
    const GeoPoint centre = PlaceAt(random.Uniform(47.3, 47.4), random.Uniform(8.5, 8.6));
    if (trial % 3 == 0) query.area = GeoCircle{centre, random.Uniform(0, 5000)};
    if (trial % 3 == 1) {
      query.area = Box(random.Uniform(47.3, 47.35), random.Uniform(8.5, 8.55),
                       random.Uniform(47.35, 47.4), random.Uniform(8.55, 8.6));
    }
    if (trial % 2 == 0) query.changed = {1'700'000'000'020, 1'700'000'000'020 + 5 * trial};
    if (trial % 5 == 0) query.viewer = "device-33";
    if (trial % 7 == 6) query.room.reset();
    std::vector<std::string> expected;
    for (const AnchorRecord& record : all) {
      const auto* circle = std::get_if<GeoCircle>(&query.area);
      const auto* box = std::get_if<GeoBox>(&query.area);
      const double lat = record.place.latitude.radians(), lon = record.place.longitude.radians();
      const bool matches =
          (query.room ? record.room == *query.room
                      : record.visibility == AnchorVisibility::kPublic) &&
          (!circle || GeodesicDistance(circle->centre, record.place) <= circle->radius_m) &&
          (!box || (lat >= box->south.radians() && lat <= box->north.radians() &&
                    lon >= box->west.radians() && lon <= box->east.radians())) &&
          (!query.changed || (record.changed_utc_ms >= query.changed->from_utc_ms &&
                              record.changed_utc_ms < query.changed->until_utc_ms)) &&
          (!query.viewer || record.visibility != AnchorVisibility::kPrivate ||
           record.owner == *query.viewer);
      if (matches) expected.push_back(record.id.text());
    }
    EXPECT_THAT(IdsOf(QueryAll(query)), UnorderedElementsAreArray(expected)) << "trial " << trial;
  }
}

TEST_P(AnchorQueries, PagesAreTheAnswerAtTheFirstPageWhateverIsWrittenBetween) {
  support::RandomGeometry random(9);
  const GeoBox west_half = Box(47.3, 8.5, 47.4, 8.55);
  for (const bool by_time : {false, true}) {
    std::map<std::string, AnchorRecord> live;
    for (std::uint64_t n = 0; n < 60; ++n) {
      const AnchorRecord record =
          Applied(store_->Create(MakeAnchor(n + (by_time ? 1000 : 0), "room")));
      live.emplace(record.id.text(), record);
    }
    AnchorQuery query{.room = kRoom, .limit = 4};
    if (by_time) query.changed = {1'700'000'001'000, 1'700'000'001'040};
    if (!by_time) query.area = west_half;
    const std::vector<AnchorRecord> expected = QueryAll(query);
    ASSERT_GT(expected.size(), 20u);
    std::vector<AnchorRecord> found;
    std::uint64_t next = 5000 + (by_time ? 1000 : 0);
    for (;;) {
      const auto page = store_->Query(query);
      ASSERT_TRUE(page) << ToString(page.error());
      found.insert(found.end(), page->anchors.begin(), page->anchors.end());
      if (!page->next) break;
      query.after = page->next;
      // Anchors appear, move across the border and back, change their time, and go.
      Applied(store_->Create(MakeAnchor(++next, "room")));
      for (int i = 0; i < 8; ++i) {
        auto chosen = live.begin();
        std::advance(chosen, random.Uniform(0, double(live.size()) - 0.001));
        AnchorRecord& record = chosen->second;
        if (i == 7 && live.size() > 20) {
          Applied(store_->Delete(record.room, record.id, record.revision));
          live.erase(chosen);
          continue;
        }
        record.place = PlaceAt(random.Uniform(47.3, 47.4), random.Uniform(8.5, 8.6));
        record.changed_utc_ms += 7;
        record = Applied(store_->Update(record, record.revision));
      }
    }
    ASSERT_EQ(IdsOf(found), IdsOf(expected));
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].revision, expected[i].revision);
      EXPECT_TRUE(SameAnchor(found[i], expected[i]));
    }
  }
}

TEST_P(AnchorQueries, FindAcrossTheDateLineAndAtThePoles) {
  AnchorRecord east = MakeAnchor(1), west = MakeAnchor(2), north = MakeAnchor(3);
  east.place = PlaceAt(-17, 179.9999);
  west.place = PlaceAt(-17, -179.9999);
  north.place = PlaceAt(90, 12);
  for (const auto& record : {east, west, north}) Applied(store_->Create(record));
  const auto find = [&](auto area) { return IdsOf(QueryAll({.room = kRoom, .area = area})); };
  EXPECT_THAT(find(Box(-18, 179, -16, -179)),
              testing::UnorderedElementsAre(IdOf(1).text(), IdOf(2).text()));
  EXPECT_THAT(find(Box(-18, 179, -16, 180)), ElementsAre(IdOf(1).text()));
  EXPECT_THAT(find(Box(89, -180, 90, 180)), ElementsAre(IdOf(3).text()));
  EXPECT_THAT(find(Box(-90, -180, 90, 180)), testing::SizeIs(3));
  EXPECT_THAT(find(Box(-17, 179.9999, -17, 179.9999)), ElementsAre(IdOf(1).text()))
      << "the rim belongs to it";
  EXPECT_THAT(find(GeoCircle{PlaceAt(90, 0), 1}), ElementsAre(IdOf(3).text()));
}

TEST_P(AnchorQueries, ARoomDoesNotSeeAnother) {
  for (const std::uint64_t n : {1, 5, 6}) Applied(store_->Create(MakeAnchor(n, "theirs")));
  EXPECT_THAT(QueryAll({.room = kRoom}), IsEmpty());
  EXPECT_THAT(IdsOf(QueryAll({})), ElementsAre(IdOf(6).text())) << "only what is public";
  const AnchorRecord secret = MakeAnchor(5, "theirs"), shared = MakeAnchor(6, "theirs");
  EXPECT_THAT(IdsOf(QueryAll({.room = RoomId("theirs"), .viewer = "device-1"})),
              testing::Not(testing::Contains(secret.id.text())));
  EXPECT_TRUE(MaySee(secret, secret.room, secret.owner));
  EXPECT_FALSE(MaySee(secret, secret.room, "device-1"));
  EXPECT_FALSE(MaySee(secret, kRoom, secret.owner));
  EXPECT_TRUE(MaySee(shared, kRoom, "device-1"));
  EXPECT_FALSE(MayEdit(shared, kRoom, shared.owner)) << "seen from another room, not touched";
  EXPECT_FALSE(MayEdit(MakeAnchor(1, "theirs"), secret.room, "device-2"));
  EXPECT_TRUE(MayEdit(MakeAnchor(1, "theirs"), secret.room, "device-1"));
}

TEST_P(AnchorQueries, ImpossibleOnesAreRefused) {
  const auto refusal = [&](const AnchorQuery& query) {
    const auto page = store_->Query(query);
    return page ? std::string("answered") : page.error().message;
  };
  EXPECT_THAT(refusal({.room = kRoom, .limit = 0}), HasSubstr("limit"));
  EXPECT_THAT(refusal({.room = kRoom, .limit = 1'000'000}), HasSubstr("limit"));
  EXPECT_THAT(refusal({.room = kRoom, .area = GeoCircle{PlaceAt(91, 0), 1}}),
              HasSubstr("latitude"));
  EXPECT_THAT(refusal({.room = kRoom, .area = GeoCircle{PlaceAt(1, 0), std::nan("")}}),
              HasSubstr("radius"));
  EXPECT_THAT(refusal({.room = kRoom, .area = Box(2, 0, 1, 0)}), HasSubstr("south"));
  EXPECT_THAT(QueryAll({.room = RoomId("\xff"), .changed = TimeSpan{5, 4}}), IsEmpty());
}

}  // namespace
}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
// What no anchor store accepts, and what each must.
#include <gmock/gmock.h>

#include <chrono>
#include <limits>

#include "content_store/anchor_rules.h"
#include "tests/content_store/anchor_stores.h"

namespace waymark::content {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

TEST_P(AnchorLimits, ValuesBeyondTheirLimitsAreRefused) {
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

TEST_P(AnchorLimits, TheLargestRecordFits) {
  AnchorRecord record = MakeAnchor(3, std::string(255, 'r'));
  record.owner = std::string(255, 'o');
  record.kind = std::string(255, 'k');
  record.payload = std::string(kMaxPayloadBytes, '\xff');
  record.epoch = std::numeric_limits<std::uint64_t>::max();
  record.created_utc_ms = std::numeric_limits<std::int64_t>::min();
  Applied(store_->Create(record));
  EXPECT_TRUE(SameAnchor(FindAnchor(record), record));
}

TEST_P(AnchorLimits, HostileTextIsOnlyText) {
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

TEST_P(AnchorLimits, NamesAreWellFormedUtf8) {
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

TEST_P(AnchorLimits, AnOwnerHoldsNoMoreThanAllowed) {
  if (!GetParam().keeps) GTEST_SKIP() << "without limits";
  Open({.limits = {.max_anchors_per_owner = 2, .max_payload_bytes_per_owner = 1000}});
  const auto make = [](std::uint64_t n, std::size_t bytes) {
    AnchorRecord record = MakeAnchor(n);
    record.owner = "device";
    record.payload = std::string(bytes, 'p');
    return record;
  };
  AnchorRecord first = Applied(store_->Create(make(1, 300)));
  const auto too_large = store_->Create(make(2, 701));
  ASSERT_FALSE(too_large);
  EXPECT_EQ(too_large.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(too_large.error().message, HasSubstr("at most 1000 bytes"));
  Applied(store_->Create(make(2, 700)));
  const auto too_many = store_->Create(make(3, 0));
  ASSERT_FALSE(too_many);
  EXPECT_THAT(too_many.error().message, HasSubstr("holds its 2 anchors already"));
  Applied(store_->Create(make(1, 300)));  // a retry is no second one
  AnchorRecord other_room = make(3, 0);
  other_room.room = RoomId("other");
  Applied(store_->Create(other_room));
  first.payload += 'p';
  EXPECT_FALSE(store_->Update(first, first.revision));
  first.payload = "";
  first = Applied(store_->Update(first, first.revision));
  Applied(store_->Delete(first.room, first.id, first.revision));
  Applied(store_->Create(make(3, 300)));
}

TEST_P(AnchorLimits, AnOwnerWritesNoFasterThanAllowed) {
  if (!GetParam().keeps) GTEST_SKIP() << "without limits";
  std::chrono::steady_clock::time_point now{};
  Open({.limits = {.max_writes_per_second = 2, .max_burst = 3}, .clock = [&] { return now; }});
  const auto write = [&](std::uint64_t n, const std::string& owner) {
    AnchorRecord record = MakeAnchor(n);
    record.owner = owner;
    const auto outcome = store_->Create(record);
    return outcome ? std::string("applied") : ToString(outcome.error());
  };
  for (std::uint64_t n = 1; n <= 3; ++n) EXPECT_EQ(write(n, "fast"), "applied");
  EXPECT_THAT(write(4, "fast"), testing::AllOf(HasSubstr("unavailable"), HasSubstr("owner fast"),
                                               HasSubstr("try again in 0.50 s")));
  EXPECT_EQ(write(4, "other"), "applied");
  now += 500ms;
  EXPECT_EQ(write(5, "fast"), "applied");
  EXPECT_THAT(write(6, "fast"), HasSubstr("try again"));
}

}  // namespace
}  // namespace waymark::content

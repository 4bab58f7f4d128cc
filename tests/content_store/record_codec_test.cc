// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/record_codec.h"

#include <gmock/gmock.h>

#include <random>

#include "content_store/anchor_rules.h"
#include "content_store/geo_json.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content::internal {
namespace {

using testing::HasSubstr;

TEST(RecordCodec, WhatWasEncodedComesBack) {
  for (std::uint64_t n = 0; n < 50; ++n) {
    AnchorState state{MakeAnchor(n), ContentFingerprint(MakeAnchor(n)), n % 7 == 6};
    state.record.revision = n * 1'000'000'007;
    const auto decoded = DecodeState(EncodeState(state));
    ASSERT_TRUE(decoded) << ToString(decoded.error());
    EXPECT_EQ(decoded->is_deleted, state.is_deleted);
    EXPECT_EQ(decoded->record.revision, state.record.revision);
    EXPECT_EQ(decoded->record.id, state.record.id);
    if (state.is_deleted) continue;
    EXPECT_TRUE(SameAnchor(decoded->record, state.record));
    EXPECT_EQ(decoded->creation, state.creation);
  }
}

TEST(RecordCodec, EveryTruncationAndExtensionIsRefused) {
  const std::string bytes = EncodeState({MakeAnchor(3), "creation"});
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(DecodeState(bytes.substr(0, size))) << size;
  }
  const auto longer = DecodeState(bytes + '\0');
  ASSERT_FALSE(longer);
  EXPECT_EQ(longer.error().code, ErrorCode::kCorrupt);
}

TEST(RecordCodec, HostileBytesNeitherCrashNorBreakTheRules) {
  std::mt19937_64 random(17);
  const std::string sound = EncodeState({MakeAnchor(3), "creation"});
  int accepted = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::string bytes = sound;
    for (auto flips = 1 + random() % 4; flips > 0; --flips) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    const auto state = DecodeState(bytes);
    if (!state) {
      EXPECT_EQ(state.error().code, ErrorCode::kCorrupt);
    } else if (!state->is_deleted) {
      ++accepted;
      EXPECT_TRUE(Validate(state->record));
    }
  }
  EXPECT_GT(accepted, 0) << "a number may change into another number; the checksum is for that";
}

TEST(Fingerprint, TellsContentApartAndIgnoresTimesAndRevision) {
  const AnchorRecord record = MakeAnchor(3);
  AnchorRecord later = record;
  later.revision = 9;
  later.created_utc_ms = later.changed_utc_ms = 5;
  EXPECT_EQ(ContentFingerprint(later), ContentFingerprint(record));
  later.payload += 'x';
  EXPECT_NE(ContentFingerprint(later), ContentFingerprint(record));
  AnchorRecord moved = record;  // the boundary between two texts matters
  moved.owner += moved.kind;
  moved.kind = "";
  EXPECT_NE(ContentFingerprint(moved), ContentFingerprint(record));
}

TEST(GeoJson, ShowsAnAnchorWithLongitudeFirst) {
  AnchorRecord record = MakeAnchor(2);
  record.place = PlaceAt(47.25, 8.5);
  record.payload = "text with \"quotes\"";
  record.map_from_anchor = Transform<Map, Anchor>(Eigen::Quaterniond::Identity(), {1, 2, 3});
  const std::string json = EncodeGeoJson(RoomSnapshot{4, {record}});
  EXPECT_THAT(json, HasSubstr("\"FeatureCollection\""));
  const auto lon = json.find("8.5"), lat = json.find("47.25");
  EXPECT_LT(lon, lat);
  EXPECT_THAT(json, HasSubstr("text with \\\"quotes\\\""));
}

TEST(GeoJson, WritesBinaryPayloadsAsBase64) {
  AnchorRecord record = MakeAnchor(2);
  for (const auto& [bytes, text] : {std::pair<std::string, std::string>{"\xff", "/w=="},
                                    {"\xff\xfe", "//4="},
                                    {"\xff\xfe\xfd", "//79"}}) {
    record.payload = bytes;
    EXPECT_THAT(EncodeGeoJson(record), HasSubstr("\"payload_base64\": \"" + text + "\""));
  }
}

}  // namespace
}  // namespace waymark::content::internal

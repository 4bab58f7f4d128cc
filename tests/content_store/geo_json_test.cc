// SPDX-License-Identifier: Apache-2.0
#include "content_store/geo_json.h"

#include <gmock/gmock.h>

#include <sstream>

#include "content_store/internal/base64.h"
#include "content_store/transfer.h"
#include "tests/content_store/anchor_fixtures.h"
#include "tests/support/memory_anchor_store.h"

namespace waymark::content {
namespace {

using testing::HasSubstr;

Result<std::vector<AnchorRecord>> Decode(const std::string& text) {
  std::istringstream in(text);
  std::vector<AnchorRecord> records;
  const auto read = DecodeGeoJson(in, [&](AnchorRecord record) -> Result<void> {
    records.push_back(std::move(record));
    return {};
  });
  if (!read) return read.error();
  return records;
}

AnchorRecord Linked(std::uint64_t n) {
  AnchorRecord record = MakeAnchor(n);
  record.payload.clear();
  record.link = {"https://example.org/a.gltf", std::string(64, '7')};
  return record;
}

TEST(GeoJsonDecoding, GivesBackWhatWasEncoded) {
  RoomSnapshot snapshot{3, {Linked(50)}};
  for (std::uint64_t n = 0; n < 42; ++n) snapshot.anchors.push_back(MakeAnchor(n));
  auto decoded = Decode(EncodeGeoJson(snapshot));
  ASSERT_TRUE(decoded) << ToString(decoded.error());
  ASSERT_EQ(decoded->size(), snapshot.anchors.size());
  for (std::size_t i = 0; i < decoded->size(); ++i) {
    AnchorRecord& found = (*decoded)[i];
    const AnchorRecord& wanted = snapshot.anchors[i];
    EXPECT_LT(GeodesicDistance(found.place, wanted.place), 1e-8);
    found.place = wanted.place;  // degrees do not keep the last bit
    EXPECT_TRUE(SameAnchor(found, wanted)) << i;
  }
}

TEST(GeoJsonDecoding, SaysWhichFeatureIsWrongAndWhy) {
  const std::string sound = EncodeGeoJson(RoomSnapshot{1, {MakeAnchor(1), MakeAnchor(3)}});
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = sound;
    const auto at = text.rfind(from);
    if (at == std::string::npos) return "no " + from;
    text.replace(at, from.size(), to);
    const auto decoded = Decode(text);
    return decoded ? std::string("decoded") : ToString(decoded.error());
  };
  EXPECT_THAT(with("\"Point\"", "\"Line\""), HasSubstr("feature 2: geometry"));
  EXPECT_THAT(with("\"epoch\": 4", "\"epoch\": -4"), HasSubstr("feature 2: epoch"));
  EXPECT_THAT(with("\"epoch\": 4", "\"epoch\": 4.5"), HasSubstr("epoch: expected a count"));
  EXPECT_THAT(with("\"editing\": \"owner\"", "\"editing\": \"all\""), HasSubstr("everyone, owner"));
  EXPECT_THAT(with("\"room\": ", "\"rom\": "), HasSubstr("room: expected it"));
  EXPECT_THAT(with("\"map_from_anchor\"", "\"pose\""), HasSubstr("map_from_anchor"));
  EXPECT_THAT(with("\"quaternion\": [", "\"quaternion\": [9,"), HasSubstr("expected 4 numbers"));
  EXPECT_THAT(with("FeatureCollection", "Feature"), HasSubstr("FeatureCollection"));
  EXPECT_THAT(with("{", "["), HasSubstr("GeoJSON"));
  EXPECT_FALSE(Decode(""));
  EXPECT_FALSE(Decode("[]"));
  EXPECT_FALSE(Decode("{\"type\": \"FeatureCollection\"}"));
  EXPECT_FALSE(Decode(std::string(100'000, '[')));
  EXPECT_TRUE(Decode("{\"type\": \"FeatureCollection\", \"features\": []}"));
}

TEST(Base64, RoundTripsAndRefusesTheRest) {
  for (std::size_t size = 0; size < 40; ++size) {
    std::string bytes;
    for (std::size_t i = 0; i < size; ++i) bytes += static_cast<char>(i * 37 + size);
    EXPECT_EQ(internal::DecodeBase64(internal::EncodeBase64(bytes)), bytes);
  }
  for (const char* text :
       {"A", "AA", "AAA", "====", "A===", "AA=A", "AAA=AAAA", "AB==", "AAB=", "AA A", "AA-_"}) {
    EXPECT_EQ(internal::DecodeBase64(text), std::nullopt) << text;
  }
}

TEST(Transfer, MovesEverythingToAnotherStoreAndMayBeRepeated) {
  support::MemoryAnchorStore from, to;
  for (std::uint64_t n = 0; n < 450; ++n) {
    Applied(from.Create(MakeAnchor(n, n % 2 == 0 ? "lobby" : "roof")));
  }
  Applied(from.Delete(RoomId("lobby"), IdOf(10), 11));
  std::stringstream file;
  const auto exported = ExportGeoJson(from, std::nullopt, file);
  ASSERT_TRUE(exported) << ToString(exported.error());
  EXPECT_EQ(exported->anchors, 449u);
  EXPECT_EQ(exported->revision, 451u);
  const auto import = [&](const ImportOptions& options) {
    std::istringstream in(file.str());
    auto report = ImportGeoJson(to, in, options);
    EXPECT_TRUE(report) << ToString(report.error());
    return report.value();
  };
  EXPECT_EQ(import({}).created, 449u);
  for (const char* room : {"lobby", "roof"}) {
    EXPECT_EQ(to.LoadRoom(RoomId(room))->anchors.size(),
              from.LoadRoom(RoomId(room))->anchors.size());
  }
  EXPECT_EQ(import({}).unchanged, 449u);
  AnchorRecord changed = *to.Find(RoomId("lobby"), IdOf(0)).value();
  changed.payload = "mine";
  Applied(to.Update(changed, changed.revision));
  const AnchorRecord gone = *to.Find(RoomId("lobby"), IdOf(2)).value();
  Applied(to.Delete(gone.room, gone.id, gone.revision));
  const ImportReport kept = import({});
  EXPECT_EQ(kept.kept, 2u);
  EXPECT_THAT(kept.examples, testing::UnorderedElementsAre(HasSubstr("its id is spent"),
                                                           HasSubstr("other content")));
  EXPECT_EQ(import({.on_difference = OnDifference::kReplace}).replaced, 1u);
  EXPECT_NE(to.Find(RoomId("lobby"), IdOf(0)).value()->payload, "mine");
  const ImportReport other = import({.room = RoomId("copy")});
  EXPECT_EQ(other.created, 449u);
  EXPECT_EQ(to.LoadRoom(RoomId("copy"))->anchors.size(), 449u);
}

}  // namespace
}  // namespace waymark::content

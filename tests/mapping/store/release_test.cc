// SPDX-License-Identifier: Apache-2.0
#include "mapping/store/release.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "tests/mapping/store/example_release.h"

namespace waymark::mapping {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string Replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Release, DecodingUndoesEncodingToTheLastBit) {
  const Release release = ExampleRelease();
  const auto decoded = DecodeRelease(EncodeRelease(release), "3.json");
  ASSERT_TRUE(decoded) << ToString(decoded.error());
  EXPECT_EQ(decoded->epoch, 3u);
  EXPECT_EQ(decoded->parent_epoch, 2u);
  EXPECT_EQ(decoded->created_utc, release.created_utc);
  ASSERT_EQ(decoded->submaps.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const ReleasedSubmap& a = decoded->submaps[i];
    const ReleasedSubmap& b = release.submaps[i];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.map_from_submap.sim().scale(), b.map_from_submap.sim().scale());
    EXPECT_EQ(a.map_from_submap.sim().translation(), b.map_from_submap.sim().translation());
    EXPECT_THAT(a.map_from_submap.sim(), support::Near(b.map_from_submap.sim()));
    EXPECT_EQ(a.centre.coordinates(), b.centre.coordinates());
    EXPECT_EQ(a.radius_m, b.radius_m);
    EXPECT_EQ(a.overlap_rms_m, b.overlap_rms_m);
    EXPECT_EQ(a.gnss_rms_m, b.gnss_rms_m);
    ASSERT_EQ(a.displacement.has_value(), i > 0);
    if (a.displacement) {
      EXPECT_EQ(a.displacement->translation_m, b.displacement->translation_m);
      EXPECT_EQ(a.displacement->scale_ratio, b.displacement->scale_ratio);
    }
  }
}

TEST(Release, EncodingWhatWasDecodedGivesTheSameText) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const std::string json = EncodeRelease(ExampleRelease(2, seed));
    EXPECT_EQ(EncodeRelease(DecodeRelease(json, "x").value()), json) << seed;
  }
}

TEST(Release, TheFirstReleaseHasNoParent) {
  Release release;
  const auto decoded = DecodeRelease(EncodeRelease(release), "1.json");
  ASSERT_TRUE(decoded) << ToString(decoded.error());
  EXPECT_FALSE(decoded->parent_epoch);
  EXPECT_TRUE(decoded->submaps.empty());
}

TEST(Release, AnotherFormatVersionIsUnsupportedAndNamesBoth) {
  const std::string json =
      Replaced(EncodeRelease(ExampleRelease()), "\"format_version\": 1", "\"format_version\": 7");
  const auto decoded = DecodeRelease(json, "releases/3.json");
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(decoded.error().message, "releases/3.json: expected map format version 1, found 7");
}

TEST(Release, WrongContentIsNamedByItsPath) {
  const std::string json = EncodeRelease(ExampleRelease());
  const std::string id = ExampleRelease().submaps[1].id.text();
  const std::vector<std::array<std::string, 3>> cases{
      {"\"epoch\": 3", "\"epoch\": 0", "3.json: epoch: expected"},
      {"\"epoch\": 3", "\"epoch\": -3", "epoch: expected a whole number, found -3"},
      {"\"parent_epoch\": 2", "\"parent_epoch\": 3", "parent_epoch: expected an epoch below 3"},
      {"\"created_utc\": \"", "\"created\": \"", "expected a member \"created_utc\""},
      {id, "../../../etc/passwd", "submaps[1].id: expected a content hash"},
      {id, ExampleRelease().submaps[0].id.text(), "submaps[1]: expected submaps sorted by id"},
      {"\"scale\": ", "\"scale\": -", "map_from_submap.scale: expected a scale"},
      {"\"radius_m\": ", "\"radius_m\": -", "submaps[0].radius_m: expected a number of at least 0"},
      {"\"displacement\": null", "\"displacement\": 4", "displacement: expected an object"},
      {"\"translation_m\": [", "\"translation_m\": [0,", "translation_m: expected 3 numbers"},
      {"\"rotation_xyzw\": [", "\"rotation_xyzw\": [[],", "rotation_xyzw: expected 4 numbers"},
  };
  for (const auto& [from, to, reason] : cases) {
    const auto decoded = DecodeRelease(Replaced(json, from, to), "3.json");
    ASSERT_FALSE(decoded) << to;
    EXPECT_EQ(decoded.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(decoded.error().message, AllOf(HasSubstr("3.json: "), HasSubstr(reason)));
  }
}

TEST(Release, NumbersThatJsonCannotSpellDoNotPassForNumbers) {
  Release release = ExampleRelease();
  release.submaps[0].gnss_rms_m = std::nan("");
  const auto decoded = DecodeRelease(EncodeRelease(release), "x");
  ASSERT_FALSE(decoded);
  EXPECT_THAT(decoded.error().message, HasSubstr("gnss_rms_m: expected a number, found null"));
  EXPECT_FALSE(DecodeRelease(Replaced(EncodeRelease(ExampleRelease()), "1.0000001", "1e999"), "x"));
}

TEST(Release, HostileTextNeverCrashes) {
  const std::string json = EncodeRelease(ExampleRelease());
  std::mt19937 engine(5);
  for (std::size_t i = 0; i < json.size(); ++i) {
    EXPECT_FALSE(DecodeRelease(json.substr(0, i), "x") && i + 1 < json.size());
    std::string flipped = json;
    flipped[i] = static_cast<char>(engine());
    (void)DecodeRelease(flipped, "x");
  }
  EXPECT_FALSE(DecodeRelease(std::string(1 << 20, '['), "x"));
  const std::string deep = std::string(1 << 20, '[') + std::string(1 << 20, ']');
  EXPECT_FALSE(DecodeRelease("{\"format_version\":1,\"epoch\":" + deep + "}", "x"));
}

}  // namespace
}  // namespace waymark::mapping

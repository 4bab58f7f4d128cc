// SPDX-License-Identifier: Apache-2.0
// `waymark-map remove` as a user meets it.
#include <gmock/gmock.h>

#include "tests/evaluation/running.h"
#include "tests/mapping/pipeline/street_map.h"

namespace waymark::mapping {
namespace {

TEST(RemoveTool, FusesWhatStaysOnlyWhenAsked) {
  const StreetMap street("remove_tool");
  street.Drive("first", {.images = 8});
  street.Drive("second", {.images = 8, .first_m = 0.3, .aside_m = 0.5, .seed = 2});
  street.Drive("north", {.images = 8, .first_m = 60, .seed = 3});
  ASSERT_TRUE(street.Add({"first", "second", "north"}).ok());
  const auto remove = [&](const std::string& experience, std::vector<std::string> options) {
    options.insert(options.begin(), {"remove", street.MapFolder(), "--experience", experience});
    return evaluation::RunProgram(WAYMARK_MAP, options, street.folder() / "log");
  };
  const auto in_place = remove("north", {});
  ASSERT_TRUE(in_place.ok()) << ToString(in_place.error());
  EXPECT_EQ(street.Open().LoadCurrentRelease()->fusion_s, std::nullopt);
  const auto fused = remove("second", {"--fuse"});
  ASSERT_TRUE(fused.ok()) << ToString(fused.error());
  EXPECT_NE(street.Open().LoadCurrentRelease()->fusion_s, std::nullopt);
}

}  // namespace
}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "content_store/anchor_rules.h"
#include "content_store/geo_json.h"
#include "mapping/base/check.h"
#include "tests/content_store/anchor_fixtures.h"
#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {

std::vector<Bytes> Seeds() {
  content::RoomSnapshot snapshot{7, {}};
  std::vector<Bytes> seeds{ToBytes(EncodeGeoJson(snapshot))};
  for (std::uint64_t n : {0U, 4U, 5U, 6U, 90U}) snapshot.anchors.push_back(content::MakeAnchor(n));
  snapshot.anchors[0].payload.clear();
  snapshot.anchors[0].link = {"https://example.org/a.gltf", std::string(64, '7')};
  seeds.push_back(ToBytes(EncodeGeoJson(snapshot)));
  for (const auto& anchor : snapshot.anchors) {
    seeds.push_back(ToBytes(EncodeGeoJson(content::RoomSnapshot{1, {anchor}})));
  }
  return seeds;
}

void TryOne(std::span<const std::uint8_t> bytes) {
  std::istringstream in{std::string(ToText(bytes))};
  const auto read = content::DecodeGeoJson(in, [](content::AnchorRecord record) -> Result<void> {
    CHECK(content::Validate(record).ok(), "a record beyond the limits was decoded");
    CHECK(!EncodeGeoJsonLine(record).empty());
    return {};
  });
  CHECK(read.ok() || read.error().code == ErrorCode::kInvalidArgument);
}

}  // namespace waymark::fuzz

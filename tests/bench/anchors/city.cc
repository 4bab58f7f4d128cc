// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/anchors/city.h"

#include <fmt/format.h>

#include <random>

namespace waymark::bench {

content::AnchorRecord City::At(std::uint64_t number) const {
  std::mt19937_64 random(number);
  std::uniform_real_distribution<double> metre(-6000, 6000);
  const Point<Map> position(metre(random), metre(random), 1);
  const std::uint64_t high = random(), low = random();
  return {.id = AnchorId(fmt::format("{:08x}-{:04x}-4{:03x}-8{:03x}-{:012x}", high >> 32,
                                     (high >> 16) & 0xffff, high & 0xfff, low >> 52,
                                     low & 0xffffffffffff)),
          .room = Room(number / anchors_per_room_),
          .owner = fmt::format("device-{}", number % 500),
          .map_from_anchor =
              Transform<Map, Anchor>(Eigen::Quaterniond::Identity(), position.coordinates()),
          .place = plane_.ToGeo(position),
          .kind = "note",
          .payload = std::string(300, 'p'),
          .created_utc_ms = 1'800'000'000'000 + static_cast<std::int64_t>(number),
          .changed_utc_ms = 1'800'000'000'000 + static_cast<std::int64_t>(number)};
}

std::vector<content::AnchorRecord> City::Group(std::uint64_t first, std::uint64_t count) const {
  std::vector<content::AnchorRecord> records;
  records.reserve(count);
  for (std::uint64_t n = first; n < first + count; ++n) records.push_back(At(n));
  return records;
}

GeoPoint City::Place(std::uint64_t number) const { return At(~number).place; }

RoomId City::Room(std::uint64_t room) const { return RoomId(fmt::format("room-{}", room)); }

}  // namespace waymark::bench

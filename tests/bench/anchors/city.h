// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "content_store/anchor_record.h"

namespace waymark::bench {

/// Anchors spread evenly over 12 x 12 km, in rooms of which each covers all of it, with payloads of
/// 300 bytes. Every number names the same anchor always.
class City {
 public:
  explicit City(std::uint64_t anchors_per_room) : anchors_per_room_(anchors_per_room) {}

  content::AnchorRecord At(std::uint64_t number) const;
  std::vector<content::AnchorRecord> Group(std::uint64_t first, std::uint64_t count) const;
  /// Somewhere in the city; `number` chooses where.
  GeoPoint Place(std::uint64_t number) const;
  RoomId Room(std::uint64_t room) const;
  std::uint64_t anchors_per_room() const { return anchors_per_room_; }

 private:
  const std::uint64_t anchors_per_room_;
  const TangentPlane plane_{{.latitude = Angle::Degrees(47.37),
                             .longitude = Angle::Degrees(8.54),
                             .ellipsoid_height_m = 400}};
};

}  // namespace waymark::bench

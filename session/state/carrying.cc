// SPDX-License-Identifier: Apache-2.0
#include "session/state/carrying.h"

#include <utility>

namespace waymark::session {

void Carry(RoomAnchor& anchor, std::uint64_t epoch, const Placements& placements) {
  anchor.is_supported = false;
  for (const content::SubmapAttachment& attachment : anchor.record.attachments) {
    const auto placed = placements.find(attachment.submap);
    if (placed == placements.end()) continue;
    anchor.is_supported = true;
    if (anchor.record.epoch != epoch) {
      anchor.record.map_from_anchor = CarryPose(placed->second, attachment.submap_from_anchor);
    }
    break;
  }
  anchor.record.epoch = epoch;
}

RoomAnchor CarryAnchor(content::AnchorRecord record, std::uint64_t epoch,
                       const Placements& placements) {
  RoomAnchor anchor{.record = std::move(record)};
  Carry(anchor, epoch, placements);
  return anchor;
}

std::optional<Transform<Map, Anchor>> CarryBetween(const Transform<Map, Anchor>& map_from_anchor,
                                                   std::span<const SubmapId> submaps,
                                                   const Placements& from, const Placements& to) {
  for (const SubmapId& submap : submaps) {
    const auto was = from.find(submap);
    const auto is = to.find(submap);
    if (was == from.end() || is == to.end()) continue;
    return CarryPose(is->second, CarryPose(was->second.Inverse(), map_from_anchor));
  }
  return std::nullopt;
}

}  // namespace waymark::session

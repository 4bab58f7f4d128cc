// SPDX-License-Identifier: Apache-2.0
#include "session/state/carrying.h"

namespace waymark::session {

RoomAnchor CarryAnchor(const content::AnchorRecord& record, std::uint64_t epoch,
                       const Placements& placements) {
  RoomAnchor anchor{.record = record, .is_supported = false};
  for (const content::SubmapAttachment& attachment : record.attachments) {
    const auto placed = placements.find(attachment.submap);
    if (placed == placements.end()) continue;
    anchor.is_supported = true;
    if (record.epoch != epoch) {
      anchor.record.map_from_anchor = CarryPose(placed->second, attachment.submap_from_anchor);
    }
    break;
  }
  anchor.record.epoch = epoch;
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

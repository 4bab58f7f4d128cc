// SPDX-License-Identifier: Apache-2.0
#include "session/server/attachments.h"

#include <algorithm>

#include "session/state/carrying.h"

namespace waymark::session {
namespace {

using mapping::ReleasedSubmap;

// Beyond this the lever arm turns small rotations of a submap into large motions of the anchor.
constexpr double kMaxDistance_m = 100;

const ReleasedSubmap* FindSubmap(const mapping::Release& release, const SubmapId& id) {
  const auto found = std::find_if(release.submaps.begin(), release.submaps.end(),
                                  [&](const ReleasedSubmap& submap) { return submap.id == id; });
  return found == release.submaps.end() ? nullptr : &*found;
}

content::SubmapAttachment Attach(const Transform<Map, Anchor>& map_from_anchor,
                                 const ReleasedSubmap& submap) {
  return {submap.id, CarryPose(submap.map_from_submap.Inverse(), map_from_anchor)};
}

double OutsideDistance_m(const ReleasedSubmap& submap, const Eigen::Vector3d& position_in_map) {
  const double to_centre_m = (submap.centre.coordinates() - position_in_map).norm();
  return std::max(0.0, to_centre_m - submap.radius_m);
}

struct Neighbour {
  double distance_m;  // outside the circle of its cameras
  double to_centre_m;
  const ReleasedSubmap* submap;
};

std::vector<Neighbour> FindNeighbours(const Eigen::Vector3d& position_in_map,
                                      const mapping::Release& release) {
  std::vector<Neighbour> neighbours;
  for (const ReleasedSubmap& submap : release.submaps) {
    const double to_centre_m = (submap.centre.coordinates() - position_in_map).norm();
    const double distance_m = OutsideDistance_m(submap, position_in_map);
    if (distance_m <= kMaxDistance_m) neighbours.push_back({distance_m, to_centre_m, &submap});
  }
  std::sort(neighbours.begin(), neighbours.end(), [](const Neighbour& a, const Neighbour& b) {
    return std::tie(a.distance_m, a.to_centre_m, a.submap->id) <
           std::tie(b.distance_m, b.to_centre_m, b.submap->id);
  });
  return neighbours;
}

// In another order those left would move the anchor by what they moved against each other.
std::vector<content::SubmapAttachment> Replenish(const content::AnchorRecord& in_live_map,
                                                 const LiveRelease& live) {
  std::vector<content::SubmapAttachment> kept, lost, nearer, farther;
  for (const content::SubmapAttachment& attachment : in_live_map.attachments) {
    (live.placements.contains(attachment.submap) ? kept : lost).push_back(attachment);
  }
  const Eigen::Vector3d position_in_map = in_live_map.map_from_anchor.translation();
  const double kept_m =
      OutsideDistance_m(*FindSubmap(live.release, kept.front().submap), position_in_map);
  std::size_t missing = kMaxAttachments - kept.size();
  for (const Neighbour& neighbour : FindNeighbours(position_in_map, live.release)) {
    const bool is_known = std::ranges::any_of(
        kept, [&](const auto& attachment) { return attachment.submap == neighbour.submap->id; });
    if (is_known || missing == 0) continue;
    --missing;
    (neighbour.distance_m < kept_m ? nearer : farther)
        .push_back(Attach(in_live_map.map_from_anchor, *neighbour.submap));
  }
  for (const auto* more : {&kept, &farther, &lost}) {
    nearer.insert(nearer.end(), more->begin(), more->end());
  }
  while (nearer.size() > kMaxAttachments) nearer.pop_back();
  return nearer;
}

}  // namespace

std::vector<content::SubmapAttachment> AttachToSubmaps(
    const Transform<Map, Anchor>& map_from_anchor, std::span<const SubmapId> seen_in,
    const mapping::Release& release) {
  std::vector<content::SubmapAttachment> attachments;
  const auto add = [&](const ReleasedSubmap& submap) {
    const bool is_known =
        std::any_of(attachments.begin(), attachments.end(),
                    [&](const auto& attachment) { return attachment.submap == submap.id; });
    if (!is_known && attachments.size() < kMaxAttachments) {
      attachments.push_back(Attach(map_from_anchor, submap));
    }
  };
  for (const SubmapId& id : seen_in) {
    if (const ReleasedSubmap* const submap = FindSubmap(release, id)) add(*submap);
  }
  for (const Neighbour& neighbour : FindNeighbours(map_from_anchor.translation(), release)) {
    add(*neighbour.submap);
  }
  return attachments;
}

Placements PlacementsOf(const mapping::Release& release) {
  Placements placements;
  for (const ReleasedSubmap& submap : release.submaps) {
    placements.emplace(submap.id, submap.map_from_submap);
  }
  return placements;
}

std::size_t CountLive(const content::AnchorRecord& record, const LiveRelease& live) {
  return std::ranges::count_if(record.attachments, [&](const auto& attachment) {
    return live.placements.contains(attachment.submap);
  });
}

content::AnchorRecord HoldIn(const LiveRelease& live, const content::AnchorRecord& record) {
  RoomAnchor carried = CarryAnchor(record, live.release.epoch, live.placements);
  if (!carried.is_supported) return record;
  carried.record.attachments = Replenish(carried.record, live);
  return std::move(carried.record);
}

}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
#include "session/server/attachments.h"

#include <algorithm>

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
    const double distance_m = std::max(0.0, to_centre_m - submap.radius_m);
    if (distance_m <= kMaxDistance_m) neighbours.push_back({distance_m, to_centre_m, &submap});
  }
  std::sort(neighbours.begin(), neighbours.end(), [](const Neighbour& a, const Neighbour& b) {
    return std::tie(a.distance_m, a.to_centre_m, a.submap->id) <
           std::tie(b.distance_m, b.to_centre_m, b.submap->id);
  });
  return neighbours;
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

}  // namespace waymark::session

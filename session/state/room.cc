// SPDX-License-Identifier: Apache-2.0
#include "session/state/room.h"

#include <algorithm>

namespace waymark::session {

void Room::Put(const RoomAnchor& anchor) {
  const std::uint64_t new_revision = anchor.record.revision;
  if (const auto found = anchors.find(anchor.record.id); found != anchors.end()) {
    if (found->second.record.revision > new_revision) return;
    digest ^= AnchorDigest(anchor.record.id, found->second.record.revision);
  }
  anchors.insert_or_assign(anchor.record.id, anchor);
  digest ^= AnchorDigest(anchor.record.id, new_revision);
  revision = std::max(revision, new_revision);
}

void Room::Remove(const AnchorId& anchor, std::uint64_t revision_of_deletion) {
  if (const auto found = anchors.find(anchor); found != anchors.end()) {
    digest ^= AnchorDigest(anchor, found->second.record.revision);
    anchors.erase(found);
  }
  revision = std::max(revision, revision_of_deletion);
}

}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
#include "session/state/room.h"

#include <algorithm>
#include <utility>

namespace waymark::session {
namespace {

constexpr double kSamePosition_m = 1e-6;
constexpr double kSameRotation_rad = 1e-6;

}  // namespace

bool IsSamePose(const Transform<Map, Anchor>& a, const Transform<Map, Anchor>& b) {
  return (a.translation() - b.translation()).norm() < kSamePosition_m &&
         AngleBetween(a.rotation(), b.rotation()).radians() < kSameRotation_rad;
}

bool LooksTheSame(const content::AnchorRecord& a, const content::AnchorRecord& b) {
  return a.epoch == b.epoch && IsSamePose(a.map_from_anchor, b.map_from_anchor) &&
         a.kind == b.kind && a.payload == b.payload && a.link == b.link &&
         a.visibility == b.visibility && a.editing == b.editing &&
         a.expires_utc_ms == b.expires_utc_ms;
}

void AnchorSet::Put(RoomAnchor anchor) {
  const std::uint64_t new_revision = anchor.record.revision;
  if (const auto found = anchors.find(anchor.record.id); found != anchors.end()) {
    const std::uint64_t known_revision = found->second.record.revision;
    if (known_revision > new_revision) return;
    if (!LooksTheSame(found->second.record, anchor.record)) {
      same_since.erase(anchor.record.id);
    } else if (known_revision < new_revision) {
      same_since.try_emplace(anchor.record.id, known_revision);
    }
    digest ^= AnchorDigest(anchor.record.id, found->second.record.revision);
  }
  digest ^= AnchorDigest(anchor.record.id, new_revision);
  revision = std::max(revision, new_revision);
  const AnchorId id = anchor.record.id;
  anchors.insert_or_assign(id, std::move(anchor));
}

bool AnchorSet::Remove(const AnchorId& anchor, std::uint64_t revision_of_deletion) {
  const auto found = anchors.find(anchor);
  if (found == anchors.end()) return false;
  digest ^= AnchorDigest(anchor, found->second.record.revision);
  anchors.erase(found);
  same_since.erase(anchor);
  revision = std::max(revision, revision_of_deletion);
  return true;
}

bool AnchorSet::IsUpToDate(const RoomAnchor& anchor, std::uint64_t known_revision) const {
  const std::uint64_t latest = anchor.record.revision;
  const auto same = same_since.find(anchor.record.id);
  const std::uint64_t first = same == same_since.end() ? latest : same->second;
  return first <= known_revision && known_revision <= latest;
}

void Passage::BeginAnew() {
  owner.clear();
  own_are_through = is_at_end = false;
  last.reset();
  submaps.clear();
}

const RoomAnchor* Room::Find(const AnchorId& anchor, const std::string& owner) const {
  const auto find_in = [&](const AnchorSet& set) {
    const auto found = set.anchors.find(anchor);
    return found == set.anchors.end() ? nullptr : &found->second;
  };
  if (const RoomAnchor* const found = find_in(shared)) return found;
  const auto mine = own.find(owner);
  return mine == own.end() ? nullptr : find_in(mine->second);
}

const RoomAnchor* Room::Find(const AnchorId& anchor) const {
  for (const auto& [owner, set] : own) {
    if (set.anchors.contains(anchor)) return Find(anchor, owner);
  }
  return Find(anchor, "");
}

RoomAnchor* Room::Find(const AnchorId& anchor) {
  const auto find_in = [&](AnchorSet& set) {
    const auto found = set.anchors.find(anchor);
    return found == set.anchors.end() ? nullptr : &found->second;
  };
  if (RoomAnchor* const found = find_in(shared)) return found;
  for (auto& [owner, set] : own) {
    if (RoomAnchor* const found = find_in(set)) return found;
  }
  return nullptr;
}

std::size_t Room::OwnCount() const {
  std::size_t count = 0;
  for (const auto& [owner, set] : own) count += set.anchors.size();
  return count;
}

}  // namespace waymark::session

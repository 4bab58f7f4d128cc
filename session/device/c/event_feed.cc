// SPDX-License-Identifier: Apache-2.0
#include "session/device/c/event_feed.h"

#include <utility>

#include "session/device/waymark_device.h"

namespace waymark::session::c {

void EventFeed::Compare(const Glance& now) {
  if (std::exchange(epoch_, now.epoch) != now.epoch) {
    untold_.push_back({WAYMARK_MAP_CHANGED, static_cast<std::int64_t>(now.epoch)});
  }
  const bool is_other_role = std::exchange(role_, now.standing.role) != now.standing.role;
  if (std::exchange(is_in_, now.standing.is_in) != now.standing.is_in || is_other_role) {
    untold_.push_back({WAYMARK_STANDING_CHANGED, is_in_});
  }
  CompareOthers(now.others);
  CompareAnchors(now.anchors);
  if (std::exchange(has_snapshot_, now.has_snapshot) != now.has_snapshot) {
    untold_.push_back({WAYMARK_SNAPSHOT, has_snapshot_});
  }
}

void EventFeed::CompareOthers(const std::vector<OtherDevice>& others) {
  std::map<DeviceId, bool> before = std::exchange(others_, {});
  for (const OtherDevice& other : others) {
    const bool was_present = before[other.id];
    before.erase(other.id);
    others_.emplace(other.id, other.is_present);
    if (was_present == other.is_present) continue;
    untold_.push_back(
        {other.is_present ? WAYMARK_DEVICE_CAME : WAYMARK_DEVICE_LEFT, 0, other.id.text()});
  }
  for (const auto& [id, was_present] : before) {
    if (was_present) untold_.push_back({WAYMARK_DEVICE_LEFT, 0, id.text()});
  }
}

void EventFeed::CompareAnchors(const std::vector<SharedAnchor>& anchors) {
  for (const SharedAnchor& anchor : anchors) {
    const auto [known, is_new] = anchors_.try_emplace(anchor.id);
    known->second.is_there = true;
    const bool is_same = !is_new && known->second.revision == anchor.revision;
    known->second.revision = anchor.revision;
    if (is_same) continue;
    untold_.push_back(
        {WAYMARK_ANCHOR_CHANGED, static_cast<std::int64_t>(anchor.revision), anchor.id.text()});
  }
  for (auto known = anchors_.begin(); known != anchors_.end();) {
    if (std::exchange(known->second.is_there, false)) {
      ++known;
      continue;
    }
    untold_.push_back({WAYMARK_ANCHOR_GONE, 0, known->first.text()});
    known = anchors_.erase(known);
  }
}

void EventFeed::Compare(localiser::AlignmentState state) {
  if (std::exchange(state_, state) == state) return;
  untold_.push_back({WAYMARK_STATE_CHANGED, static_cast<std::int64_t>(state)});
}

std::optional<Event> EventFeed::Take() {
  if (untold_.empty()) return std::nullopt;
  Event event = std::move(untold_.front());
  untold_.pop_front();
  return event;
}

}  // namespace waymark::session::c

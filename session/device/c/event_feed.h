// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "session/device/device_session.h"

namespace waymark::session::c {

/// One thing that happened; kinds and values are those of waymark_device.h.
struct Event {
  std::int32_t kind = 0;
  std::int64_t value = 0;
  std::string id = {};

  friend bool operator==(const Event&, const Event&) = default;
};

/// What can be seen of a session at one moment.
struct Glance {
  std::vector<OtherDevice> others;
  std::vector<SharedAnchor> anchors;
  RoomStanding standing;
  bool has_snapshot = false;
  std::uint64_t epoch = 0;
};

/// Tells what changed from one glance to the next. Memory is that of the room, however seldom it is
/// asked. Pure; thread-compatible.
class EventFeed {
 public:
  /// Of a session whose map had this release when it began.
  explicit EventFeed(std::uint64_t epoch) : epoch_(epoch) {}

  /// Only once everything told before was taken.
  void Compare(const Glance& now);
  void Compare(localiser::AlignmentState state);
  void Tell(const Event& event) { untold_.push_back(event); }
  std::optional<Event> Take();

 private:
  struct Known {
    std::uint64_t revision = 0;
    bool is_there = false;  // in the present glance
  };

  void CompareOthers(const std::vector<OtherDevice>& others);
  void CompareAnchors(const std::vector<SharedAnchor>& anchors);

  std::deque<Event> untold_;
  std::map<DeviceId, bool> others_;  // whether present
  std::map<AnchorId, Known> anchors_;
  std::uint64_t epoch_;
  bool has_snapshot_ = false;
  bool is_in_ = true;
  Role role_ = Role::kMember;
  localiser::AlignmentState state_ = localiser::AlignmentState::kNever;
};

}  // namespace waymark::session::c

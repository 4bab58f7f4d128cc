// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "session/state/anchor_relay.h"
#include "session/state/events.h"

namespace waymark::session {

/// A device that has joined.
struct RoomMember {
  DeviceId device;
  RoomId room;
  std::string name;
  Ticket ticket{};
  DeviceNumber number{};
  ServerTime last_heard;
  std::optional<LivePose> pose;
  bool pose_is_due = false;
  std::deque<SubmapId> found_in = {};  ///< by its latest images, newest first
  ServerTime pose_published;
  std::set<Uuid> under_way;           ///< commands that wait for the store
  std::deque<CommandReply> answered;  ///< oldest first, for repetitions
  std::uint32_t attempt = 0;          ///< of the latest Hello
  bool is_return = false;             ///< with that it came back as itself
  event::Permit permit = {};          ///< that it came with
  ServerTime own_told = {};           ///< when it was told all that its owner alone may see
  bool is_own_due = false;            ///< it is to be told anew
  ServerTime area_heard = {};         ///< when it last said in what it is interested

  Role role() const { return permit.role; }
  /// Of what it places.
  const std::string& owner() const { return permit.owner.empty() ? device.text() : permit.owner; }
  /// The answer to a command that it repeats; null where there is none or it is forgotten.
  const CommandReply* FindAnswer(const Uuid& request) const {
    const auto found = std::ranges::find(answered, request, &CommandReply::request);
    return found == answered.end() ? nullptr : &*found;
  }
};

bool IsSamePose(const Transform<Map, Anchor>& a, const Transform<Map, Anchor>& b);
/// Whether two states of an anchor are the same to people: at most its submaps differ.
bool LooksTheSame(const content::AnchorRecord& a, const content::AnchorRecord& b);

/// Anchors that the store has acknowledged and the same people may see.
struct AnchorSet {
  std::map<AnchorId, RoomAnchor> anchors;
  std::uint64_t revision = 0;
  std::uint64_t digest = 0;
  /// Since which revision people see an anchor as it is: later ones only attached it anew.
  std::map<AnchorId, std::uint64_t> same_since;

  /// Brings an anchor to the state that the store acknowledged; a later state wins. States are
  /// compared, so both must be in the live map.
  void Put(RoomAnchor anchor);
  /// Whether it was there.
  bool Remove(const AnchorId& anchor, std::uint64_t revision_of_deletion);
  /// Whether who knows this revision of an anchor knows it as it is.
  bool IsUpToDate(const RoomAnchor& anchor, std::uint64_t known_revision) const;
};

/// How far the anchors of a room have come on their way to another release, in which they are told
/// some at a time: its owners' first, by owner and name.
struct Passage {
  std::string owner;                ///< whose are next; those of all before are through
  bool own_are_through = false;     ///< all owners'
  bool is_at_end = false;           ///< those for all too
  std::optional<AnchorId> last;     ///< of the present set; absent: it has not begun
  std::set<AnchorId> again = {};    ///< to be told once more
  std::set<SubmapId> submaps = {};  ///< that carry those for all; as many as a MapState holds
  /// Where the live release shows those that it does not support: no submap leads back there.
  std::map<AnchorId, Transform<Map, Anchor>> unsupported = {};

  bool IsThrough() const { return is_at_end && again.empty(); }
  void BeginAnew();
};

/// A room in memory.
struct Room {
  bool is_open = false;                       ///< false: its anchors are being read
  bool has_parts = false;                     ///< some of them have been
  std::vector<event::HelloReceived> waiting;  ///< while not open, or on its way
  std::optional<Passage> passage;             ///< present: told anchors are of two releases
  std::set<DeviceId> members;
  std::vector<DeviceId> poses_due;       ///< some of them may have left since
  std::uint32_t poses_told = 0;          ///< in which tick
  std::set<DeviceId> away;               ///< silent for a while; their seats are kept
  AnchorSet shared;                      ///< seen by all
  std::map<std::string, AnchorSet> own;  ///< by owner: seen by its devices alone
  AnchorRelay relay;                     ///< knows the shared ones
  std::map<DeviceId, AnchorRelay::Listener> listeners;  ///< members that asked for an area
  std::optional<RoomState> told;                        ///< the latest
  std::size_t writes_under_way = 0;
  std::uint64_t followed = 0;                ///< up to here the store's feed has told everything
  std::set<AnchorId> removed;                ///< deleted here; the feed has not told it yet
  std::vector<content::AnchorChange> early;  ///< told while not open
  ServerTime last_used;

  /// The anchor as an owner may see it.
  const RoomAnchor* Find(const AnchorId& anchor, const std::string& owner) const;
  /// What holds it, whoever may see it; null: nothing.
  const RoomAnchor* Find(const AnchorId& anchor) const;
  RoomAnchor* Find(const AnchorId& anchor);
  std::size_t OwnCount() const;  ///< of all owners
  bool HasAnchors() const { return !shared.anchors.empty() || !own.empty(); }
};

}  // namespace waymark::session

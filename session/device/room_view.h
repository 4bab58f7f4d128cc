// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "session/device/anchor_shelf.h"
#include "session/device/device_session.h"
#include "session/device/remote_track.h"
#include "session/state/messages.h"

namespace waymark::session {

/// What a device knows of its room: the others and the anchors, those of its owner alone too. Pure;
/// thread-compatible.
class RoomView {
 public:
  /// Of the anchors that are for all, it is told those of the room or of an area.
  explicit RoomView(const DeviceId& self, AnchorScope scope = AnchorScope::kRoom)
      : self_(self), scope_(scope) {}

  /// The server answered, in this run and with this release live. A new run begins a new snapshot.
  void StartRun(RunId run, std::uint64_t epoch);
  /// Another release is live. Anchors that came already in its frame are shown so from now on, the
  /// others are carried by their submaps, or wait to come.
  void CarryTo(std::uint64_t epoch, const Placements& placements);
  /// Everything is about to be delivered anew: what is not, is over.
  void BeginResync();
  /// The same of one alone.
  void OnLost(const DeviceId& device);
  void OnLost(const AnchorId& anchor, bool is_own) { (is_own ? own_ : room_).Lose(anchor); }

  void On(const Presence& presence);
  void OnGone(const DeviceId& device, ServerTime now);
  void On(const PoseBatch& batch, ServerTime now);
  void On(const AnchorState& state);
  /// `is_own`: the end of a private one; by default of whatever is known by this id.
  void OnGone(const AnchorId& anchor, std::optional<bool> is_own = std::nullopt);
  void On(const RoomState& state);
  void On(const OwnerState& state);
  void On(const AreaState& state);
  /// What a command of ours brought about or found, which may be known before its publication.
  void OnOwnChange(const RoomAnchor& anchor);

  /// Those who left stay for half a minute, marked.
  std::vector<OtherDevice> Others(ServerTime now) const;
  std::vector<SharedAnchor> Anchors() const;
  std::optional<SharedAnchor> FindAnchor(const AnchorId& anchor) const;
  bool HasSnapshot() const { return room_.IsComplete() && own_.IsComplete(); }

 private:
  struct Other {
    Presence presence;
    RemoteTrack track = RemoteTrack();
    std::optional<ServerTime> gone_since;
    std::uint32_t delivery = 0;
  };
  AnchorShelf& ShelfOf(const RoomAnchor& anchor);
  /// An anchor is on both shelves while it goes from one to the other.
  const AnchorShelf::Held* FindLatest(const AnchorId& anchor) const;

  DeviceId self_;
  AnchorScope scope_;
  RunId run_{};
  std::map<DeviceId, Other> others_;
  std::map<DeviceNumber, DeviceId> numbers_;  // of the present run
  std::uint32_t delivery_ = 1;                // counts resynchronisations
  AnchorShelf room_, own_;
};

SharedAnchor ToShared(const RoomAnchor& anchor);

}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <vector>

#include "session/device/device_session.h"
#include "session/device/remote_track.h"
#include "session/state/messages.h"

namespace waymark::session {

/// What a device knows of its room: the others and the anchors. Pure; thread-compatible.
///
/// The snapshot rule: anchors arrive one by one and in no order with the room's state. They are all
/// there when those of the server's present run agree with the state in count and digest. Anchors
/// of an earlier run stay visible until then and are dropped at that moment. After a silence long
/// enough for deletions to be forgotten, the anchors delivered since are asked likewise.
class RoomView {
 public:
  explicit RoomView(const DeviceId& self) : self_(self) {}

  /// The server answered, in this run and with this release live. A new run begins a new snapshot.
  void StartRun(RunId run, std::uint64_t epoch);
  /// Another release is live. Anchors that came already in its frame are shown so from now on, the
  /// others are carried by their submaps, or wait to come.
  void CarryTo(std::uint64_t epoch, const Placements& placements);
  /// Everything is about to be delivered anew: what is not, is over.
  void BeginResync();

  void On(const Presence& presence);
  void OnGone(const DeviceId& device, ServerTime now);
  void On(const PoseBatch& batch, ServerTime now);
  void On(const AnchorState& state);
  void OnGone(const AnchorId& anchor);
  void On(const RoomState& state);
  /// What a command of ours brought about or found, which may be known before its publication.
  void OnOwnChange(const RoomAnchor& anchor);

  /// Those who left stay for half a minute, marked.
  std::vector<OtherDevice> Others(ServerTime now) const;
  std::vector<SharedAnchor> Anchors() const;
  std::optional<SharedAnchor> FindAnchor(const AnchorId& anchor) const;
  bool HasSnapshot() const { return has_snapshot_; }

 private:
  struct Other {
    Presence presence;
    RemoteTrack track = RemoteTrack();
    std::optional<ServerTime> gone_since;
    std::uint32_t delivery = 0;
  };
  struct HeldAnchor {
    RunId run{};
    RoomAnchor anchor;  ///< the latest
    RoomAnchor shown;   ///< in the frame that the device's pose is in, as far as known
    std::uint32_t delivery = 0;
  };
  /// Count and digest of some anchors.
  struct Tally {
    std::size_t count = 0;
    std::uint64_t digest = 0;
  };

  void Hold(RunId run, const RoomAnchor& anchor);
  void Count(const HeldAnchor& held, bool is_added);
  bool Agrees(const Tally& tally) const;
  void CheckSnapshot();

  DeviceId self_;
  RunId run_{};
  std::uint64_t epoch_ = 0;
  std::map<DeviceId, Other> others_;
  std::map<DeviceNumber, DeviceId> numbers_;  // of the present run
  std::map<AnchorId, HeldAnchor> anchors_;
  std::set<AnchorId> deleted_;  // ids are never used again
  std::uint32_t delivery_ = 1;  // counts resynchronisations
  Tally of_run_;                // anchors of the present run
  Tally of_delivery_;           // those of them that came since the last resynchronisation
  std::optional<RoomState> room_;
  bool has_snapshot_ = false;
};

SharedAnchor ToShared(const RoomAnchor& anchor);

}  // namespace waymark::session

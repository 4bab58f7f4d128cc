// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <set>

#include "session/state/messages.h"

namespace waymark::session {

/// Anchors that a device is told of, and whether they are all there: those of its room, or those of
/// its owner alone. Pure; thread-compatible.
///
/// Anchors arrive one by one and in no order with the state that says how many they are. They are
/// all there when those of the server's present run agree with it in count and digest. Anchors of
/// an earlier run stay visible until then and are dropped at that moment. After a silence long
/// enough for deletions to be forgotten, the anchors delivered since are asked likewise.
class AnchorShelf {
 public:
  struct Held {
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

  void StartRun(RunId run, std::uint64_t epoch);
  void CarryTo(std::uint64_t epoch, const Placements& placements);
  void BeginResync();
  /// As BeginResync, of one alone.
  void Lose(const AnchorId& anchor);
  /// What it shall hold, in this run: of everything, or in an area. What is elsewhere is let go.
  void Expect(RunId run, const Tally& all, const std::optional<AnchorArea>& area = std::nullopt);

  /// Told by the server in a run of its.
  void Put(RunId run, const RoomAnchor& anchor);
  /// Known by the answer to a command of ours, perhaps before it is told.
  void PutOwnChange(const RoomAnchor& anchor);
  void Remove(const AnchorId& anchor);

  const std::map<AnchorId, Held>& anchors() const { return anchors_; }
  const Held* Find(const AnchorId& anchor) const;
  bool IsComplete() const { return is_complete_; }
  /// Whether it matters: not when it came late, for an area that was left.
  bool Shows(const Held& held) const {
    return !area_ || area_->Holds(held.anchor.record.map_from_anchor.translation());
  }

 private:
  void Hold(RunId run, const RoomAnchor& anchor);
  void Count(const Held& held, bool is_added);
  void CountAnew();
  bool Agrees(const Tally& tally) const;
  void Check();

  RunId run_{};
  std::uint64_t epoch_ = 0;
  std::map<AnchorId, Held> anchors_;
  std::set<AnchorId> deleted_;  // ids are never used again
  std::uint32_t delivery_ = 1;  // counts resynchronisations
  Tally of_run_;                // anchors of the present run
  Tally of_delivery_;           // those of them that came since the last resynchronisation
  struct Expected {
    RunId run{};
    Tally all;
  };
  std::optional<Expected> expected_;
  std::optional<AnchorArea> area_;  // in which anchors are counted
  bool is_complete_ = false;
};

}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "session/gateway/phone.h"
#include "session/state/anchor_relay.h"
#include "session/state/pose_relay.h"
#include "session/wire/room_line.h"

namespace waymark::session::internal {

/// A room that phones of this gateway stand in. What the server tells it is heard, decoded and
/// encoded once for all of them; each is told the poses that matter to it. Thread-safe.
class Room : public std::enable_shared_from_this<Room> {
 public:
  using PhonePtr = std::shared_ptr<Phone>;

  /// Errors: those of RoomLine::Create.
  static Result<std::shared_ptr<Room>> Open(std::shared_ptr<dds::Participant> participant,
                                            const RoomId& room, const RelayOptions& relay,
                                            socket::SocketLoop& loop);

  /// The phone waits at the door: it keeps the room open and is told nothing.
  void Enter(const PhonePtr& phone);
  /// From now on it hears what is said to its device alone, until it leaves; and what is said to
  /// its owner's devices is kept for it until it is admitted.
  void ListenFor(const DeviceId& device, const std::string& owner, const PhonePtr& phone);
  /// From now on it is told what the room is told, after all that still holds of what was; unless
  /// it left meanwhile. Who joins anew, after a silence of the server, is told all of that once
  /// more: he has begun to count anew what is delivered.
  void Admit(const PhonePtr& phone);
  /// A phone that hears of areas alone asks for one.
  void SetArea(const PhonePtr& phone, const AreaReport& report);
  /// Says whether nobody is left.
  bool Leave(const PhonePtr& phone);

  wire::RoomLine& line() { return *line_; }

 private:
  /// The last word on something, as a frame.
  struct Word {
    RunId run{};
    wire::SharedFrame frame;
  };

  struct AnchorWord : Word {
    std::uint64_t epoch = 0;
  };

  /// The last words on what an owner alone may see.
  struct OwnWords {
    std::map<AnchorId, Word> anchors;
    Word state;
  };

  Room(const RelayOptions& relay, socket::SocketLoop& loop) : loop_(loop), relay_(relay) {}

  // On DDS threads.
  void Hear(const wire::Downward& message);
  void TellOne(const DeviceId& device, const wire::Downward& message);
  void On(const PoseBatch& batch, const wire::SharedFrame&);
  void On(const Presence& presence, const wire::SharedFrame& frame);
  void On(const wire::DeviceGone& gone, const wire::SharedFrame& frame);
  void OnOwn(const AnchorState& state, const wire::SharedFrame& frame);
  void OnOwn(const wire::AnchorGone& gone, const wire::SharedFrame& frame);
  void OnOwn(const OwnerState& state, const wire::SharedFrame& frame);
  bool HearOwn(const wire::Downward& message, const wire::SharedFrame& frame);
  void TellOwner(const std::string& owner, const wire::SharedFrame& frame);
  void On(const AnchorState& state, const wire::SharedFrame& frame);
  void On(const wire::AnchorGone& gone, const wire::SharedFrame& frame);
  void On(const RoomState& state, const wire::SharedFrame& frame);
  void On(const MapState& state, const wire::SharedFrame& frame);
  void TellAll(const wire::SharedFrame& frame, std::optional<wire::Slot> slot);
  void TellOfAnchor(const AnchorRelay::Change& change, const wire::SharedFrame& frame);
  /// No anchor is told in another release than the live one.
  bool IsOfOneRelease() const;
  void TellAreaState(const PhonePtr& phone, AnchorRelay::Listener& listener);
  void ForgetAnchor(const AnchorWord& word);
  void ForgetWords();
  void ForgetRuns(const std::function<bool(RunId)>& is_over);

  // On the loop.
  void TellPoses();

  socket::SocketLoop& loop_;
  std::mutex mutex_;
  // Guarded by mutex_.
  std::set<PhonePtr> waiting_;
  std::multimap<DeviceId, PhonePtr> by_device_;  // several connections may say the same name
  std::map<PhonePtr, PoseRelay::Listener> phones_;
  PoseRelay relay_;
  PoseBatch tick_;  // the one heard last, without poses
  bool is_telling_ = false;
  std::map<DeviceId, Word> presences_;
  std::map<AnchorId, AnchorWord> anchors_;
  std::map<std::uint64_t, std::size_t> anchors_of_epochs_;  // how many
  std::uint64_t epoch_ = 0;                                 // that is live in the room
  AnchorRelay anchor_relay_;                                // knows the same
  std::map<PhonePtr, AnchorRelay::Listener> by_area_;
  Word state_, map_;
  std::multimap<std::string, PhonePtr> by_owner_;
  std::map<std::string, OwnWords> own_;  // of owners who have a phone here

  std::unique_ptr<wire::RoomLine> line_;  // last: its threads use all of the above
};

}  // namespace waymark::session::internal

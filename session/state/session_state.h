// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "session/state/anchor_rules.h"
#include "session/state/events.h"
#include "session/state/room.h"

namespace waymark::session {

/// Who may be the first in a room.
enum class RoomOpening : std::uint8_t { kEveryone, kModerators };

struct StateOptions {
  std::chrono::nanoseconds presence_timeout = std::chrono::seconds(3);  ///< silence that is absence
  /// Whoever was lost and not said goodbye is itself again, not a newcomer, when it returns within
  /// this time; its seat is kept. Beyond presence_timeout it is gone for the others meanwhile.
  std::chrono::nanoseconds return_within = std::chrono::seconds(60);
  std::chrono::nanoseconds ban = std::chrono::minutes(10);        ///< of a device that was removed
  std::chrono::nanoseconds room_idle = std::chrono::seconds(60);  ///< an empty room is kept so long
  std::chrono::nanoseconds pose_repeat = std::chrono::milliseconds(500);  ///< of who stands still
  std::chrono::nanoseconds max_clock_error = std::chrono::seconds(10);    ///< of a pose's time
  std::size_t max_rooms = 64;
  std::size_t max_members = 1024;          ///< of a room; moderators may set less
  std::size_t max_anchors = 200'000;       ///< of a room; and private ones of all its owners
  std::size_t max_told_anchors = 20'000;   ///< of a room: with more, devices must say which area
  std::size_t max_own_anchors = 1'000;     ///< private ones of an owner in a room
  std::size_t max_writes_per_device = 32;  ///< waiting for the store
  std::size_t max_rules = 10'000;          ///< bans, and rooms with a capacity of their own
  AnchorRights rights = AnchorRights::kEveryone;
  RoomOpening opening = RoomOpening::kEveryone;

  Result<void> Validate() const;
};

/// The rules of a session: who is in which room, who is gone, where everybody is, and what becomes
/// of anchor commands. Pure: the same events at the same times give the same effects, so a log of
/// them replays a session. No clock, thread, socket or randomness inside. Thread-compatible.
class SessionState {
 public:
  /// `placements` are those of the map's release; without them what devices said just before a
  /// first swap cannot be carried.
  SessionState(const StateOptions& options, RunId run, const MapIdentity& map,
               std::shared_ptr<const Placements> placements = nullptr);

  std::vector<Effect> Apply(const Event& event, ServerTime now);

  /// Who holds the ticket.
  const RoomMember* FindMember(Ticket ticket) const;
  std::size_t MemberCount() const { return members_.size(); }
  std::size_t AwayCount() const { return away_.size(); }
  std::size_t RoomCount() const { return rooms_.size(); }
  std::uint64_t epoch() const { return map_.epoch; }  ///< that is live

 private:
  /// What one event leads to.
  struct Step {
    ServerTime now;
    std::vector<Effect> effects;
  };
  struct PendingWrite {
    DeviceId device;
    std::string owner;  // of the device
    Uuid request;
    AnchorOperation operation;
    content::AnchorRecord intended;
  };
  /// A moderator's, in force already.
  struct PendingDecision {
    std::uint64_t version;  // of the rules, that holds it first
    DeviceId moderator;
    Uuid request;
  };
  /// All rooms on their way to another release.
  struct Carrying {
    std::uint64_t epoch = 1;
    std::shared_ptr<const Placements> placements;   // of it
    bool is_live = false;                           // it is the live one already
    std::optional<effect::ReportSwap> report = {};  // absent: another one was given up
  };

  void On(const event::HelloReceived& event, Step& step);
  void On(const event::DeviceLeft& event, Step& step);
  void On(const event::Heard& event, Step& step);
  void On(const event::PoseReceived& event, Step& step);
  void On(const event::CommandReceived& event, Step& step);
  void On(const event::RoomPartLoaded& event, Step& step);
  void On(const event::RoomLoaded& event, Step& step);
  void On(const event::WriteFinished& event, Step& step);
  void On(const event::StoreChanged& event, Step& step);
  void On(const event::Localised& event, Step& step);
  void On(const event::ReleaseSwapped& event, Step& step);
  void On(const event::Ticked& event, Step& step);
  void On(const event::PermitsRevoked& event, Step& step);
  void On(const event::RoomCommandReceived& event, Step& step);
  void On(const event::AreaReceived& event, Step& step);
  void On(const event::RulesFound& event, Step& step);
  void On(const event::RulesKept& event, Step& step);

  std::optional<std::string> FindObjection(const event::HelloReceived& event, ServerTime now) const;
  std::optional<std::string> FindBan(const event::HelloReceived& event, ServerTime now) const;
  void Renew(RoomMember& member, const event::HelloReceived& event, Step& step);
  void OpenFor(const event::HelloReceived& event, Step& step);
  void Wait(Room& room, const event::HelloReceived& event, Step& step);
  void Admit(const event::HelloReceived& event, Step& step);
  void Seat(RoomMember member, Step& step);
  void Greet(const RoomMember& member, Step& step);
  void Announce(const RoomMember& member, Step& step);
  void Refuse(const Hello& hello, JoinVerdict verdict, const std::string& reason, Step& step);
  RoomMember Unseat(const DeviceId& device, Step& step);
  void Remove(const DeviceId& device, Step& step) { (void)Unseat(device, step); }
  void SetAway(const DeviceId& device, Step& step);
  std::optional<RoomMember> TakeAway(const DeviceId& device);
  void SendAway(const DeviceId& device, const std::string& reason, Step& step);
  std::optional<CommandVerdict> Moderate(const RoomCommand& command, const RoomMember& member,
                                         Step& step);
  std::optional<CommandVerdict> RemoveByModerator(const RoomCommand& command,
                                                  const RoomMember& moderator, Step& step);
  std::optional<CommandVerdict> SetCapacity(const RoomCommand& command, const RoomId& room);
  std::uint32_t CapacityOf(const RoomId& room) const;
  void KeepRules(Step& step);
  void LookAround(Step& step);
  void RemoveSilent(Step& step);
  void EndPermits(Step& step);
  void ForgetAbsent(Step& step);
  RoomMember* FindKnown(const DeviceId& device);
  void CloseIdleRooms(Step& step);
  void WantPublished(RoomMember& member);
  void PublishPoses(const RoomId& id, Room& room, Step& step);
  void PublishState(const RoomId& id, Room& room, Step& step);
  void PublishMap(const RoomId& id, const Room& room, Step& step);
  void Follow(Room& room, const content::AnchorChange& change, Step& step);
  void ShowLoaded(const RoomId& id, Room& room, const std::vector<RoomAnchor>& anchors, Step& step);
  void Show(Room& room, RoomAnchor anchor, Step& step);
  void PublishAnchor(Room& room, const RoomAnchor& anchor, Step& step);
  void PublishAreas(Room& room, Step& step);
  void Hide(Room& room, const RoomId& id, const AnchorId& anchor, std::uint64_t revision,
            Step& step);
  void ShowOwn(Room& room, RoomAnchor anchor, Step& step);
  void HideOwn(Room& room, const AnchorId& anchor, std::uint64_t revision, Step& step);
  void HideShared(Room& room, const RoomId& id, const AnchorId& anchor, std::uint64_t revision,
                  Step& step);
  void TellOwnChange(const Room& room, const std::string& owner,
                     const std::variant<AnchorState, AnchorId>& change, Step& step);
  void TellOwn(RoomMember& member, Step& step);
  void TellOwnDue(Step& step);
  OwnerState StateOf(const Room& room, const std::string& owner) const;
  void GoLive(Step& step);
  void CarryOn(Step& step);
  Room* FindRoomToCarry();
  void CarrySome(Room& room, int& budget, Step& step);
  bool CarrySome(AnchorSet& set, Room& room, int& budget, Step& step);
  void CarryAcross(RoomAnchor& anchor, Passage& passage);
  void TellCarried(Room& room, const RoomAnchor& anchor, Step& step);
  void Arrive(Step& step);
  void LetIn(Room& room, Step& step);
  bool IsStaging() const { return carrying_ && !carrying_->is_live; }
  void SetInLiveMap(RoomAnchor& anchor, const Passage& passage) const;
  void Settle(Room& room, const AnchorId& anchor);
  RoomAnchor InLiveMap(const content::AnchorRecord& record) const;
  RoomAnchor InLiveMap(RoomAnchor anchor) const;
  AnchorCommand InLiveMap(const AnchorCommand& command) const;
  void Acknowledge(Room& room, const PendingWrite& write, const RoomAnchor& written, Step& step);
  void Answer(RoomMember& member, const Uuid& request, const AnchorId& anchor,
              const CommandVerdict& verdict, Step& step);
  RoomMember* FindHeard(Ticket ticket, ServerTime now);
  DeviceNumber TakeNumber();

  StateOptions options_;
  RunId run_;
  MapIdentity map_;
  std::shared_ptr<const Placements> placements_;         ///< of the live release, if known
  std::shared_ptr<const Placements> placements_before_;  ///< of the release before, if known
  std::uint64_t epoch_before_ = 0;
  std::uint32_t swaps_ = 0;
  std::optional<Carrying> carrying_;  ///< absent: all are in the live release
  std::map<RoomId, Room> rooms_;
  std::map<DeviceId, RoomMember> members_;
  struct AwayMember {
    RoomMember member;
    ServerTime since;
  };

  std::map<DeviceId, AwayMember> away_;
  RoomRules rules_;
  std::uint64_t rules_version_ = 0;                ///< counts what was decided
  std::optional<std::uint64_t> rules_being_kept_;  ///< which version, while it is
  std::vector<PendingDecision> decisions_;         ///< to be answered when they are kept
  std::map<Ticket, DeviceId> tickets_;
  std::map<WriteNumber, PendingWrite> writes_;
  std::uint32_t next_number_ = 1;
  std::uint64_t next_write_ = 1;
  std::uint32_t tick_ = kTicksPerFrame;
  ServerTime looked_around_ = {};
};

}  // namespace waymark::session

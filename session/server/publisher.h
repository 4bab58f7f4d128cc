// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <utility>
#include <variant>

#include "session/server/area_publisher.h"
#include "session/server/owner_publisher.h"
#include "session/server/server.h"
#include "session/state/events.h"
#include "session/state/pose_relay.h"
#include "session/wire/server_bus.h"

namespace waymark::session {

/// Carries out on the bus what the state wants said. Ends are given time: a device that is told no
/// must be able to hear it, and a reader with losses must be able to learn that an anchor is gone.
/// Thread-compatible; times are the session's.
class Publisher {
 public:
  using Clock = std::function<ServerTime()>;

  /// `clock` stamps what is sent when it is sent: a tick for many devices takes a while.
  Publisher(wire::ServerBus& bus, const RelayOptions& relay, ServerCounters& counters, Clock clock)
      : bus_(bus),
        relay_options_(relay),
        counters_(counters),
        clock_(std::move(clock)),
        owners_(bus),
        areas_(bus) {}

  void Do(const effect::OpenRoom& effect, ServerTime now);
  void Do(const effect::CloseRoom& effect, ServerTime now);
  void Do(const effect::SendWelcome& effect, ServerTime now);
  void Do(const effect::CloseDevice& effect, ServerTime now);
  void Do(const effect::PublishPresence& effect, ServerTime now);
  void Do(const effect::WithdrawPresence& effect, ServerTime now);
  void Do(const effect::PublishPoses& effect, ServerTime now);
  void Do(const effect::PublishAnchor& effect, ServerTime now);
  void Do(const effect::WithdrawAnchor& effect, ServerTime now);
  void Do(const effect::PublishRoomState& effect, ServerTime now);
  void Do(const effect::PublishMapState& effect, ServerTime now);
  void Do(const effect::ReportSwap& effect, ServerTime now);
  void Do(const effect::SendReply& effect, ServerTime now);
  void Do(const effect::SendOwn& effect, ServerTime now) { owners_.Do(effect, now); }
  void Do(const effect::SendOwnChange& effect, ServerTime now) { owners_.Do(effect, now); }
  void Do(const effect::TellArea& effect, ServerTime now) { areas_.Do(effect, now); }

  /// Closes and forgets what has been over for long enough.
  void Tend(ServerTime now);

 private:
  template <typename Key>
  using Withdrawn = std::map<std::pair<RoomId, Key>, ServerTime>;

  /// Who is told the poses of a room by the server itself.
  struct Audience {
    PoseRelay relay;
    std::map<DeviceId, PoseRelay::Listener> listeners;
  };
  void Log(const RoomId& room, const Welcome& welcome, ServerTime now);

  template <typename Key>
  void Forget(Withdrawn<Key>& withdrawn, ServerTime now);
  void TellGateways(const effect::PublishPoses& effect, ServerTime now);
  void TellDevices(const effect::PublishPoses& effect, ServerTime now);

  wire::ServerBus& bus_;
  const RelayOptions relay_options_;
  ServerCounters& counters_;
  const Clock clock_;
  ServerTime log_second_;    // refusals are logged by the second
  int refusals_logged_ = 0;  // in it
  std::map<DeviceId, RoomId> open_devices_;
  std::map<RoomId, Audience> audiences_;
  std::map<DeviceId, ServerTime> closing_devices_;  // since when
  Withdrawn<DeviceId> withdrawn_devices_;
  Withdrawn<AnchorId> withdrawn_anchors_;
  OwnerPublisher owners_;
  AreaPublisher areas_;
};

}  // namespace waymark::session

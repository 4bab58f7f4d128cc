// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "session/dds/participant.h"
#include "session/wire/shares.h"
#include "session/wire/traffic.h"

namespace waymark::session::wire {

/// The server's end of the star. Messages arrive, already checked, on DDS threads: the handler only
/// enqueues. Everything else is thread-compatible.
class ServerBus {
 public:
  using Handler = std::function<void(Upward)>;
  using GatewayHandler = std::function<void(GatewayReport)>;

  /// Cut into `slices`, each with a participant of its own, see slices.h. Who comes to another
  /// slice than its room's is told to which. Errors: InvalidArgument, those of Participant::Create.
  static Result<std::unique_ptr<ServerBus>> Create(const dds::ParticipantOptions& options,
                                                   int slices, const ShareOptions& share,
                                                   Handler handler, GatewayHandler gateway_handler);
  ~ServerBus();

  /// What is published to a room that is not open, or sent to a device that is not, goes nowhere.
  Result<void> OpenRoom(const RoomId& room);
  void CloseRoom(const RoomId& room);
  Result<void> OpenDevice(const RoomId& room, const DeviceId& device);
  void CloseDevice(const DeviceId& device);
  bool IsOpen(const DeviceId& device) const;
  /// It is open, but its latest Hello came another way, on the bus or through a gateway: open it
  /// anew.
  bool HasChangedItsWay(const DeviceId& device) const;
  /// What one of them is told goes where the other is told it too: gateways speak for both in one
  /// room.
  bool ShareTheirWay(const DeviceId& a, const DeviceId& b) const;

  Result<void> Publish(const RoomId& room, const Presence& presence);
  /// Heard by gateways, which choose from it for each of their phones.
  Result<void> Publish(const RoomId& room, const PoseBatch& batch);
  bool IsHeardByGateways(const RoomId& room) const;
  Result<void> Publish(const RoomId& room, const AnchorState& state);
  Result<void> Publish(const RoomId& room, const RoomState& state);
  Result<void> Publish(const RoomId& room, const MapState& state);

  /// Tells the room that it is over. `Forget`, some time later, frees the trace of it that the
  /// history keeps for late joiners; too soon, and a reader with losses would miss the end.
  Result<void> Withdraw(const RoomId& room, const DeviceId& device);
  Result<void> Withdraw(const RoomId& room, const AnchorId& anchor);
  void Forget(const RoomId& room, const DeviceId& device);
  void Forget(const RoomId& room, const AnchorId& anchor);

  /// To the device named in the message.
  Result<void> Send(const Welcome& welcome);
  Result<void> Send(const LocaliseAnswer& answer);
  Result<void> Send(const CommandReply& reply);
  Result<void> Send(const ClockPong& pong);
  Result<void> Send(const DeviceId& device, const PoseBatch& batch);
  /// What its owner's devices alone are told. A gateway hears it once for all that it speaks for.
  Result<void> Send(const DeviceId& device, const AnchorState& own);
  Result<void> Send(const DeviceId& device, const OwnerState& state);
  Result<void> Withdraw(const DeviceId& device, const AnchorId& own);
  void Forget(const DeviceId& device, const AnchorId& own);
  void Forget(const DeviceId& device, const std::string& owner);

  /// To a device that speaks for itself and asked for an area. `Withdraw…` tells it that an anchor
  /// is over; what is forgotten is no longer told to its late readers.
  Result<void> SendInArea(const DeviceId& device, const AnchorState& state);
  Result<void> SendInArea(const DeviceId& device, const AreaState& state);
  void WithdrawInArea(const DeviceId& device, const AnchorId& anchor);
  void ForgetInArea(const DeviceId& device, const AnchorId& anchor);
  void ForgetArea(const DeviceId& device);

  /// False: the device is not there, or a gateway hears its poses for it.
  bool HearsPoses(const DeviceId& device) const;
  /// To the gateway named in the message.
  Result<void> Send(const GatewayPongs& pongs);

  std::uint64_t RejectedMessages() const;   ///< did not decode
  std::uint64_t ThrottledMessages() const;  ///< beyond the share of who said them

 private:
  struct Impl;

  explicit ServerBus(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark::session::wire

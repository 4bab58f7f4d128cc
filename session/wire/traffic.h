// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <variant>

#include "session/state/messages.h"

/// All that travels between devices and the server.
namespace waymark::session::wire {

/// A device said goodbye, or its process is gone from the network.
struct Farewell {
  DeviceId device;
  bool is_lost = false;
};

/// Anything a device may say.
using Upward = std::variant<Hello, Farewell, PoseReport, LocaliseQuery, AnchorCommand, ClockPing,
                            RoomCommand, AreaReport>;

/// Another device left, or was lost.
struct DeviceGone {
  DeviceId device;
};
/// An anchor was deleted, or is not to be seen any more.
struct AnchorGone {
  AnchorId anchor;
  bool is_own = false;  ///< of those that its owner alone was told of
};

/// Anything the server may say.
using Downward =
    std::variant<Welcome, Presence, DeviceGone, PoseBatch, LocaliseAnswer, AnchorState, AnchorGone,
                 CommandReply, RoomState, MapState, ClockPong, OwnerState, AreaState>;

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <variant>

#include "mapping/base/result.h"
#include "session/wire/traffic.h"

namespace waymark::session::wire {

/// A device's end of the star, whatever carries it. Sending is thread-safe.
class DeviceLink {
 public:
  /// The way to the server is open, for the first time or anew: what was said before may be lost.
  struct Opened {};
  /// What follows tells everything that holds of the room once more: what it does not tell is over.
  struct ToldAnew {};
  /// Nobody vouches for it any more, because the server is away: it is over unless told anew.
  struct DeviceLost {
    DeviceId device;
  };
  struct AnchorLost {
    AnchorId anchor;
    bool is_own = false;  ///< a private one of the device's owner
  };
  using Event = std::variant<Opened, ToldAnew, DeviceLost, AnchorLost, Downward>;
  /// Takes messages, already checked, on threads of the link: it only enqueues.
  using Handler = std::function<void(Event)>;

  virtual ~DeviceLink() = default;

  /// Errors: Unavailable; what is not sent is due again soon, nothing is said only once.
  virtual Result<void> Send(Upward message) = 0;
  /// Bytes of the latest image that have not left yet, which a newer image would make needless; 0
  /// where that cannot be known.
  virtual std::size_t WaitingImageBytes() const { return 0; }
  /// Says goodbye and waits a moment for the server to hear it.
  virtual void SayFarewell() = 0;
};

/// Who may speak at all. Errors: InvalidArgument (a room's name, a device id that is no UUID).
Result<void> CheckIdentity(const RoomId& room, const DeviceId& device);

}  // namespace waymark::session::wire

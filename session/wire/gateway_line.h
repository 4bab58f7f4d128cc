// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "session/dds/participant.h"
#include "session/state/messages.h"

namespace waymark::session::wire {

/// What the phones of a gateway say many times a second, whatever their room: gathered and sent
/// together, because a message costs more than its bytes. Thread-safe.
class GatewayLine {
 public:
  /// Called on DDS threads: it only enqueues.
  using Handler = std::function<void(ClockPong)>;

  /// Errors: Unavailable.
  static Result<std::unique_ptr<GatewayLine>> Create(std::shared_ptr<dds::Participant> participant,
                                                     GatewayId gateway, Handler handler);
  ~GatewayLine();

  void Gather(const PoseReport& report);
  void Gather(const ClockPing& ping);
  /// Sends what has been gathered; call it every few milliseconds. What does not fit one message
  /// goes at once.
  void Flush();

 private:
  struct Impl;

  explicit GatewayLine(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "session/dds/participant.h"
#include "session/wire/gateway_line.h"

namespace waymark::session::internal {

/// A gateway's ends of the bus, one on each of its slices (session/wire/slices.h). Thread-safe
/// between `Listen` and `Close`.
class BusLines {
 public:
  /// Errors: InvalidArgument (slices), those of Participant::Create.
  static Result<BusLines> Connect(const dds::ParticipantOptions& options, int slices);

  /// Errors: those of GatewayLine::Create.
  Result<void> Listen(const wire::GatewayLine::Handler& handler);
  /// What was given to `Listen` is not called any more, and nothing is gathered.
  void Close();

  const std::shared_ptr<dds::Participant>& ParticipantOf(const RoomId& room) const {
    return participants_[IndexOf(room)];
  }
  wire::GatewayLine& LineOf(const RoomId& room) { return *lines_[IndexOf(room)]; }
  void Flush();

 private:
  std::size_t IndexOf(const RoomId& room) const;

  std::vector<std::shared_ptr<dds::Participant>> participants_;  // one of each slice
  std::vector<std::unique_ptr<wire::GatewayLine>> lines_;        // likewise
};

}  // namespace waymark::session::internal

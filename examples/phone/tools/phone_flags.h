// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "examples/phone/replay.h"
#include "session/device/device_session.h"

namespace waymark::phone {

/// What the command line says.
struct Flags {
  std::string walk;
  std::string out;
  session::DeviceOptions device;
  ReplayOptions replay;
  double anchor_distance_m = 3;
  std::optional<DeviceId> kick;  ///< sent away instead of walking
  std::string kick_reason = "sent away by a moderator";
};

/// Nothing when the program is to end, with that exit status: help, or flags that make no sense.
std::optional<Flags> ParseFlags(int argc, char** argv, int& exit_status);

}  // namespace waymark::phone

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "tests/bench/session/city.h"

namespace waymark::bench {

inline constexpr std::string_view kDevicesAreMade = "devices: made";
inline constexpr std::string_view kDevicesHaveJoined = "devices: joined";

// What the bench starts beside itself. Each prints one line once it serves, its DDS domain or its
// port on this machine, and stays until it is ended; 1 when it cannot.

/// Waymark's server on a free domain, with its anchors in a file if there are any. It records to
/// that file, if any. At SIGUSR1 another release of the map goes live.
int RunServer(const std::string& recording, const CityAnchors& anchors, int slices);
/// Waymark's gateway to that server, in clear or with a certificate that vouches for itself.
int RunGateway(int domain, bool is_tls);
/// Devices on the bus, each a participant, in a room of their own: says a line when they are made,
/// and joins and says another at SIGUSR1.
int RunDevices(int domain, int count, int first, int slices);
/// A plain fan-out over WebSockets.
int RunFanOut();

}  // namespace waymark::bench

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace waymark::bench {

inline constexpr std::string_view kDevicesAreMade = "devices: made";
inline constexpr std::string_view kDevicesHaveJoined = "devices: joined";

// What the bench starts beside itself. Each prints one line once it serves, its DDS domain or its
// port on this machine, and stays until it is ended; 1 when it cannot.

/// Anchors that stand in the first room of a crowd from the beginning, in a square about the
/// origin.
struct CityAnchors {
  int count = 0;
  double edge_m = 0;
};

/// Waymark's server on a free domain, with anchors in memory. It records to that file, if any.
int RunServer(const std::string& recording, const CityAnchors& anchors);
/// Waymark's gateway to that server, in clear or with a certificate that vouches for itself.
int RunGateway(int domain, bool is_tls);
/// Devices on the bus, each a participant: says a line when they are made, and joins and says
/// another at SIGUSR1.
int RunDevices(int domain, int count, int first);
/// A plain fan-out over WebSockets.
int RunFanOut();

}  // namespace waymark::bench

// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::bench {

// What the bench starts beside itself. Each prints one line once it serves, its DDS domain or its
// port on this machine, and stays until it is ended; 1 when it cannot.

/// Waymark's server on a free domain, with anchors in memory.
int RunServer();
/// Waymark's gateway to that server, without TLS.
int RunGateway(int domain);
/// A plain fan-out over WebSockets.
int RunFanOut();

}  // namespace waymark::bench

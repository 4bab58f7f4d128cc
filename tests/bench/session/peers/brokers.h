// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/bench/session/child.h"
#include "tests/bench/session/peers/protocol.h"

namespace waymark::bench {

/// A broker that runs, and how phones speak with it.
struct Broker {
  Child process;
  std::uint16_t port;
  std::unique_ptr<Protocol> protocol;
};

/// A way of others. Each start is a fresh one, on a free port of this machine, that keeps nothing
/// on disk. Errors: Unavailable.
struct Peer {
  std::string way;
  Result<Broker> (*start)();
};

/// Those that are installed; says which are not.
std::vector<Peer> FindPeers();

}  // namespace waymark::bench

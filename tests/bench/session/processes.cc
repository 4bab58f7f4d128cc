// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/processes.h"

#include <fmt/format.h>
#include <unistd.h>

#include "tests/bench/session/peers/web_socket_fan_out.h"
#include "tests/session/session_fixture.h"
#include "tests/support/memory_anchor_store.h"

namespace waymark::bench {
namespace {

/// SIGTERM ends it as it ends any process.
int StayUntilTold() {
  while (true) ::pause();
}

}  // namespace

int RunServer() {
  session::ServerOptions options{.dds_domain = -1};
  const auto server = session::support::StartOnFreeDomain(options, [&] {
    return session::support::MakeParts(session::support::MakeRelease(),
                                       std::make_unique<waymark::support::MemoryAnchorStore>());
  });
  if (!server) return 1;
  fmt::print("{}\n", options.dds_domain);
  std::fflush(stdout);
  return StayUntilTold();
}

int RunGateway(int domain) {
  const auto gateway =
      session::Gateway::Start({.dds = {.domain = domain}, .max_joins_per_s = 1000});
  if (!gateway) return 1;
  fmt::print("{}\n", (*gateway)->port());
  std::fflush(stdout);
  return StayUntilTold();
}

int RunFanOut() {
  FanOut fan_out;
  const auto port = fan_out.Listen();
  if (!port) return 1;
  fmt::print("{}\n", *port);
  std::fflush(stdout);
  return StayUntilTold();
}

}  // namespace waymark::bench

// SPDX-License-Identifier: Apache-2.0
// A device or a server in a process of its own, to be killed.
//   session_peer device DOMAIN NAME          joins the room "square"; any line it reads, it answers
//                                            with how often it came back as itself
//   session_peer server DOMAIN STORE         serves a map of one submap
// Prints one line when it is there, and ends when its standard input does.
#include <fmt/format.h>

#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>

#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

template <typename T>
int Stay(const Result<T>& started, const std::string& line,
         const std::function<std::string()>& answer = nullptr) {
  fmt::print("{}\n", started.ok() ? line : ToString(started.error()));
  std::fflush(stdout);
  if (!started.ok()) return 1;
  for (std::string input; std::getline(std::cin, input);) {
    fmt::print("{}\n", answer ? answer() : "");
    std::fflush(stdout);
  }
  return 0;
}

int RunDevice(int domain, const std::string& name) {
  const auto session = DeviceSession::Join({.dds_domain = domain,
                                            .room = RoomId("square"),
                                            .name = name,
                                            .request_timeout = std::chrono::seconds(30)});
  return Stay(session, session.ok() ? (*session)->id().text() : "",
              [&] { return fmt::format("returns={}", (*session)->Standing().returns); });
}

int RunServer(int domain, const std::string& store_path) {
  auto store = content::OpenSqliteStore(store_path);
  if (!store.ok()) return Stay(store, "");
  const mapping::Release release = support::MakeRelease();
  const auto server =
      Server::Start({.dds_domain = domain}, support::MakeParts(release, *std::move(store)));
  return Stay(server, "serving");
}

}  // namespace
}  // namespace waymark::session

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const int domain = std::atoi(argv[2]);
  return argv[1] == std::string("device") ? waymark::session::RunDevice(domain, argv[3])
                                          : waymark::session::RunServer(domain, argv[3]);
}

// SPDX-License-Identifier: Apache-2.0
// A device or a server in a process of its own, to be halted, killed or given another clock.
//   session_peer device SERVER DOMAIN NAME [TOKEN]   joins the room "square"
//   session_peer server DOMAIN STORE [KEYS]          serves a map of one submap
// Prints one line when it is there, and ends when its standard input does. A device answers each
// line: "place TEXT" with "placed" or what is wrong, any other with how it stands.
#include <fmt/format.h>

#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>

#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using Answer = std::function<std::string(const std::string& line)>;

template <typename T>
int Stay(const Result<T>& started, const std::string& line, const Answer& answer = nullptr) {
  fmt::print("{}\n", started.ok() ? line : ToString(started.error()));
  std::fflush(stdout);
  if (!started.ok()) return 1;
  for (std::string input; std::getline(std::cin, input);) {
    fmt::print("{}\n", answer ? answer(input) : "");
    std::fflush(stdout);
  }
  return 0;
}

std::string Place(DeviceSession& session, support::StandingPhone& phone, const std::string& text) {
  if (!phone.Localise()) return "not localised";
  const auto placed = session.PlaceAnchor(support::kAhead, "note", text);
  return placed.ok() ? "placed" : ToString(placed.error());
}

std::string Describe(const DeviceSession& session) {
  const auto others = session.Others();
  const RoomStanding standing = session.Standing();
  return fmt::format(
      "returns={} joins={} in={} others={} anchors={}", standing.returns,
      session.Statistics().joins, standing.is_in ? "yes" : standing.reason,
      std::count_if(others.begin(), others.end(), [](const auto& o) { return o.is_present; }),
      session.Anchors().size());
}

int RunDevice(const std::vector<std::string>& words) {
  const auto session = DeviceSession::Join({.server = words[1],
                                            .dds_domain = std::atoi(words[2].c_str()),
                                            .room = RoomId("square"),
                                            .name = words[3],
                                            .token = words.size() > 4 ? words[4] : "",
                                            .request_timeout = std::chrono::seconds(30)});
  if (!session.ok()) return Stay(session, "");
  support::StandingPhone phone(**session, {3, 4, 1});
  return Stay(session, (*session)->id().text(), [&](const std::string& line) {
    const std::string place = "place ";
    return line.starts_with(place) ? Place(**session, phone, line.substr(place.size()))
                                   : Describe(**session);
  });
}

int RunServer(const std::vector<std::string>& words) {
  auto store = content::OpenSqliteStore(words[2]);
  if (!store.ok()) return Stay(store, "");
  ServerParts parts = support::MakeParts(support::MakeRelease(), *std::move(store));
  if (words.size() > 3) {
    auto door = keys::TokenDoor::Open({.folder = words[3]});
    if (!door.ok()) return Stay(door, "");
    parts.door = *std::move(door);
  }
  const auto server =
      Server::Start({.dds_domain = std::atoi(words[1].c_str()), .rules_file = words[2] + ".rules"},
                    std::move(parts));
  return Stay(server, "serving");
}

}  // namespace
}  // namespace waymark::session

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() >= 4 && words[0] == "device") return waymark::session::RunDevice(words);
  if (words.size() >= 3 && words[0] == "server") return waymark::session::RunServer(words);
  return 2;
}

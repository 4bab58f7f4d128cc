// SPDX-License-Identifier: Apache-2.0
// A server or a phone in a process of its own, to be killed.
//   network_peer server ADDRESS STORE         finds every image where its prior says
//   network_peer phone URL AUTHORITY NAME     walks, and places an anchor
// Each says "ready" and stays until it is killed, or its parent is gone.
#include <fmt/format.h>
#include <unistd.h>

#include <string>

#include "tests/session/session_fixture.h"

namespace waymark {
namespace {

/// Not longer than the test, whatever becomes of that.
class Parent {
 public:
  bool IsThere() const { return ::getppid() == parent_; }

 private:
  pid_t parent_ = ::getppid();
};

int Fail(const Error& error) {
  fmt::print("{}\n", ToString(error));
  return 1;
}

void SayReady() {
  fmt::print("ready\n");
  std::fflush(stdout);
}

int RunServer(const std::string& address, const std::string& store_path) {
  const Parent parent;
  auto store = content::OpenSqliteStore(store_path);
  if (!store.ok()) return Fail(store.error());
  const auto server = session::Server::Start(
      {.address = address},
      session::support::MakeParts(session::support::MakeRelease(), *std::move(store)));
  if (!server.ok()) return Fail(server.error());
  SayReady();
  while (parent.IsThere()) ::sleep(1);
  return 0;
}

int RunPhone(const std::string& url, const std::string& authority, const std::string& name) {
  const Parent parent;
  const auto phone = session::DeviceSession::Join({.server = url,
                                                   .authority_file = authority,
                                                   .room = RoomId("square"),
                                                   .name = name,
                                                   .request_timeout = std::chrono::seconds(30)});
  if (!phone.ok()) return Fail(phone.error());
  session::support::StandingPhone walker(**phone, {1, 2, 1});
  SayReady();
  for (int i = 0; parent.IsThere(); ++i) {
    walker.MoveTo({0.01 * (i % 500), 2, 1});
    walker.Live();
    if (i % 90 == 60) {
      const auto anchor = (*phone)->PlaceAnchor(session::support::kAhead, "note", name);
      if (anchor.ok()) (void)(*phone)->DeleteAnchor(*anchor);
    }
    ::usleep(33'000);
  }
  return 0;
}

}  // namespace
}  // namespace waymark

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() == 3 && words[0] == "server") return waymark::RunServer(words[1], words[2]);
  if (words.size() == 4 && words[0] == "phone") {
    return waymark::RunPhone(words[1], words[2], words[3]);
  }
  return 2;
}

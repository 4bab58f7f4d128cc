// SPDX-License-Identifier: Apache-2.0
// Somebody on the bus without a library of ours to hold it back, whose own machine checks nothing
// (blind_checks.cc):
//   session_stranger FOLDER DOMAIN DEVICE [WORDS INSTEAD]
// speaks for DEVICE in the room "square" and listens to all that DEVICE may, with the credentials
// of FOLDER, or none if that is "-". Its own plug-ins read INSTEAD where WORDS are written.
// Prints a line when it is there. For every line "speak" that it reads it says what it can to the
// server, and answers how much it has heard so far; from "flood" on, once the server has let it in,
// it says as much as it can, and answers how many messages that were so far.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <string>
#include <thread>

#include "session/wire/internal/topics.h"
#include "tests/session/blind_checks.h"
#include "tests/session/wire_fixture.h"

namespace waymark::session {
namespace {

const RoomId kSquare("square");

class Stranger {
 public:
  Stranger(dds::Participant participant, const DeviceId& device)
      : participant_(std::move(participant)), device_(device) {}

  Result<void> Begin() {
    const std::string down = wire::DownPartition(kSquare);
    const std::string own = wire::DevicePartition(kSquare, device_);
    WAYMARK_TRY(Listen<Presence>(down));
    WAYMARK_TRY(Listen<RoomState>(down));
    WAYMARK_TRY(Listen<MapState>(down));
    WAYMARK_TRY(Listen<AnchorState>(down));
    WAYMARK_TRY(Listen<PoseBatch>(down));
    WAYMARK_TRY_ASSIGN(dds::Reader welcome, wire::MakeReader<Welcome>(participant_, own, rejected_,
                                                                      [this](const Welcome& heard) {
                                                                        ++heard_;
                                                                        ticket_ = heard.ticket;
                                                                      }));
    readers_.push_back(std::move(welcome));
    WAYMARK_TRY(Listen<AnchorState>(own));
    WAYMARK_TRY(Listen<OwnerState>(own));
    WAYMARK_TRY(Listen<PoseBatch>(own));
    const std::string up = wire::UpPartition(kSquare, device_);
    WAYMARK_TRY_ASSIGN(hello_, wire::MakeWriter<Hello>(participant_, up));
    WAYMARK_TRY_ASSIGN(poses_, wire::MakeWriter<PoseReport>(participant_, up));
    WAYMARK_TRY_ASSIGN(commands_, wire::MakeWriter<AnchorCommand>(participant_, up));
    WAYMARK_TRY_ASSIGN(pings_, wire::MakeWriter<ClockPing>(participant_, up));
    WAYMARK_TRY_ASSIGN(queries_, wire::MakeWriter<LocaliseQuery>(participant_, up));
    return {};
  }

  /// As somebody who comes, is somewhere and places an anchor.
  void Speak() {
    ++attempt_;
    (void)wire::Write(*hello_, Hello{.device = device_,
                                     .protocol = kProtocol,
                                     .attempt = attempt_,
                                     .room = kSquare,
                                     .name = "stranger"});
    (void)wire::Write(*poses_, PoseReport{});
    (void)wire::Write(*commands_, AnchorCommand{.anchor = AnchorId(device_.text())});
  }
  int heard() const { return heard_; }

  /// Begins a flood that lasts as long as the process, when the server knows it.
  std::uint64_t Flood() {
    Speak();
    if (ticket_.load() != Ticket{} && !flood_.joinable()) flood_ = std::thread([this] { Pour(); });
    return said_;
  }

 private:
  [[noreturn]] void Pour() {
    LocaliseQuery query = wire::MakeQuery();
    query.ticket = ticket_;
    query.earlier = {};
    query.image.assign(20'000, 7);
    AnchorCommand command{.ticket = ticket_,
                          .operation = AnchorOperation::kMove,
                          .anchor = AnchorId(device_.text()),
                          .payload = std::string(1000, 'x')};
    for (std::uint64_t round = 0;; ++round) {
      (void)wire::Write(*poses_, PoseReport{.ticket = ticket_, .pose = {}});
      (void)wire::Write(*pings_, ClockPing{ticket_, static_cast<std::uint32_t>(round), {}});
      command.request = UuidFromBits(1, round);
      (void)wire::Write(*commands_, command);
      said_ += 3;
      if (round % 16 == 0) {
        query.request = RequestNumber{static_cast<std::uint32_t>(round)};
        (void)wire::Write(*queries_, query);
        ++said_;
      }
    }
  }

  template <typename Message>
  Result<void> Listen(const std::string& partition) {
    WAYMARK_TRY_ASSIGN(dds::Reader reader,
                       wire::MakeReader<Message>(participant_, partition, rejected_,
                                                 [this](const Message&) { ++heard_; }));
    readers_.push_back(std::move(reader));
    return {};
  }

  dds::Participant participant_;
  const DeviceId device_;
  std::uint32_t attempt_ = 0;
  std::optional<dds::Writer> hello_, poses_, commands_, pings_, queries_;
  std::atomic<int> heard_ = 0;
  std::atomic<Ticket> ticket_{};
  std::atomic<std::uint64_t> said_ = 0;
  std::thread flood_;
  std::atomic<std::uint64_t> rejected_ = 0;
  std::vector<dds::Reader> readers_;  // last: their callbacks end before the rest goes
};

int Live(const std::string& folder, int domain, const std::string& device) {
  auto participant =
      dds::Participant::Create({.domain = domain, .security_folder = folder == "-" ? "" : folder});
  if (!participant.ok()) return fmt::print("{}\n", ToString(participant.error())), 1;
  Stranger stranger(*std::move(participant), DeviceId(device));
  const Result<void> begun = stranger.Begin();
  fmt::print("{}\n", begun.ok() ? "there" : ToString(begun.error()));
  std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line);) {
    if (line == "flood") {
      fmt::print("{}\n", stranger.Flood());
    } else {
      stranger.Speak();
      fmt::print("{}\n", stranger.heard());
    }
    std::fflush(stdout);
  }
  std::_Exit(0);  // whatever it still says
}

}  // namespace
}  // namespace waymark::session

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  if (std::freopen("/dev/null", "w", stderr) == nullptr) return 2;  // the log is the server's
  if (argc == 6) waymark::session::support::ThePretence() = {argv[4], argv[5]};
  return waymark::session::Live(argv[1], std::atoi(argv[2]), argv[3]);
}

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <string>
#include <vector>

#include "session/state/session_state.h"

namespace waymark::session::support {

/// Plays events to a SessionState and keeps the effects of the last one. Devices go by one letter.
class StateScript : public testing::Test {
 protected:
  static DeviceId Device(char letter) {
    return DeviceId(FormatUuid(UuidFromBits(0, static_cast<std::uint64_t>(letter))));
  }
  static AnchorId AnchorNamed(int number) {
    return AnchorId(FormatUuid(UuidFromBits(1, static_cast<std::uint64_t>(number))));
  }
  static Uuid Request(int number) { return UuidFromBits(2, static_cast<std::uint64_t>(number)); }
  static Ticket TicketOf(char letter) { return Ticket{1000u + static_cast<unsigned>(letter)}; }

  const std::vector<Effect>& Play(const Event& event) {
    effects_ = state_.Apply(event, now_);
    return effects_;
  }
  void Wait(std::chrono::milliseconds duration) { now_ += duration; }

  void Hello(char letter, const std::string& room = "square", std::uint32_t protocol = kProtocol) {
    Play(event::HelloReceived{{.device = Device(letter),
                               .protocol = protocol,
                               .attempt = 7,
                               .room = RoomId(room),
                               .name = std::string(1, letter)},
                              TicketOf(letter)});
  }
  void LoadRoom(const std::string& room = "square", std::vector<RoomAnchor> anchors = {}) {
    Play(event::RoomLoaded{RoomId(room), std::uint64_t{0}, std::move(anchors)});
  }
  /// A room that is open, with these devices in it.
  void OpenWith(const std::string& letters) {
    Hello(letters.front());
    LoadRoom();
    for (const char letter : letters.substr(1)) Hello(letter);
  }
  void Pose(char letter, double x, std::uint64_t epoch = 1) {
    Play(event::PoseReceived{{.ticket = TicketOf(letter), .pose = MakePose(x, epoch)}});
  }
  /// How many ticks it took, of the few in the period of a frame.
  std::uint32_t TickUntilPosesAreTold() {
    std::uint32_t ticks = 0;
    do {
      Wait(std::chrono::milliseconds(8));
      Play(event::Ticked{});
      ++ticks;
    } while (None<effect::PublishPoses>() && ticks < kTicksPerFrame);
    return ticks;
  }
  LivePose MakePose(double x, std::uint64_t epoch = 1) const {
    return {.epoch = epoch,
            .time = now_,
            .map_from_device = {Eigen::Quaterniond::Identity(), {x, 0, 0}},
            .sigma_m = 0.1};
  }

  AnchorCommand Command(char letter, int request, AnchorOperation operation, int anchor,
                        std::uint64_t expected_revision = 0, double x = 0) const {
    return {.ticket = TicketOf(letter),
            .request = Request(request),
            .operation = operation,
            .anchor = AnchorNamed(anchor),
            .expected_revision = expected_revision,
            .epoch = 1,
            .map_from_anchor = {Eigen::Quaterniond::Identity(), {x, 0, 0}},
            .kind = "note",
            .payload = "p"};
  }
  /// The store does the write that the last event asked for.
  void StoreApplies(std::uint64_t revision) {
    const auto wanted = Only<effect::WriteAnchor>();
    RoomAnchor anchor{.record = wanted.record, .is_supported = true};
    anchor.record.revision = revision;
    Play(event::WriteFinished{wanted.write, event::WriteFinished::Applied{anchor}});
  }
  void StoreRefuses(const std::optional<RoomAnchor>& current) {
    const auto wanted = Only<effect::WriteAnchor>();
    Play(event::WriteFinished{wanted.write, event::WriteFinished::Conflict{current}});
  }

  template <typename Wanted>
  std::vector<Wanted> All() const {
    std::vector<Wanted> found;
    for (const Effect& effect : effects_) {
      if (const auto* wanted = std::get_if<Wanted>(&effect)) found.push_back(*wanted);
    }
    return found;
  }
  template <typename Wanted>
  Wanted Only() const {
    const std::vector<Wanted> found = All<Wanted>();
    CHECK(found.size() == 1, "expected one such effect, found {}", found.size());
    return found.front();
  }
  template <typename Wanted>
  bool None() const {
    return All<Wanted>().empty();
  }

  StateOptions options_{};
  MapIdentity map_{.map = "m", .origin = {}};
  SessionState state_{options_, RunId{42}, map_};
  ServerTime now_{std::chrono::hours(1)};
  std::vector<Effect> effects_;
};

}  // namespace waymark::session::support

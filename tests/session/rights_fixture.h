// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tests/session/state_fixture.h"

namespace waymark::session::support {

/// A state whose devices come with roles.
class RightsScript : public StateScript {
 protected:
  /// As Hello, with what a token came to.
  void HelloAs(char letter, const event::Permit& permit, const std::string& room = "square") {
    Play(event::HelloReceived{{.device = Device(letter),
                               .attempt = 7,
                               .room = RoomId(room),
                               .name = std::string(1, letter)},
                              TicketOf(letter),
                              permit});
  }
  void HelloAs(char letter, Role role) { HelloAs(letter, event::Permit{.role = role}); }

  /// A room with a moderator M, a member A and a viewer V.
  void OpenWithRoles() {
    HelloAs('M', Role::kModerator);
    LoadRoom();
    HelloAs('A', Role::kMember);
    HelloAs('V', Role::kViewer);
  }
  /// What comes of it is kept at once.
  void Say(char letter, int request, RoomOperation operation, char target = 'A',
           std::uint32_t capacity = 0) {
    SayOnly(letter, request, operation, target, capacity);
    if (None<effect::KeepRules>()) return;
    const std::vector<Effect> before = effects_;
    Play(event::RulesKept{Only<effect::KeepRules>().version});
    effects_.insert(effects_.begin(), before.begin(), before.end());
  }
  void SayOnly(char letter, int request, RoomOperation operation, char target = 'A',
               std::uint32_t capacity = 0) {
    Play(event::RoomCommandReceived{{.ticket = TicketOf(letter),
                                     .request = Request(request),
                                     .operation = operation,
                                     .device = Device(target),
                                     .capacity = capacity,
                                     .reason = "spam"}});
  }
  Welcome Answer() const { return Only<effect::SendWelcome>().welcome; }
};

}  // namespace waymark::session::support

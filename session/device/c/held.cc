// SPDX-License-Identifier: Apache-2.0
#include "session/device/c/held.h"

#include "session/device/c/handles.h"

namespace waymark::session::c {
namespace {

// Numbers that outlive their objects need a place that outlives them too: the one thing here that
// is global. Never destroyed, because sessions may still be in use while the process ends.
HandleTable<HeldOptions>& OptionsTable() {
  static auto& table = *new HandleTable<HeldOptions>(1);
  return table;
}
HandleTable<HeldSession>& SessionTable() {
  static auto& table = *new HandleTable<HeldSession>(2);
  return table;
}

}  // namespace

std::uint64_t Hold(std::shared_ptr<HeldOptions> options) {
  return OptionsTable().Add(std::move(options));
}
std::uint64_t Hold(std::shared_ptr<HeldSession> session) {
  return SessionTable().Add(std::move(session));
}
std::shared_ptr<HeldOptions> ReleaseOptions(WaymarkOptions options) {
  return OptionsTable().Remove(options);
}
std::shared_ptr<HeldSession> ReleaseSession(WaymarkSession session) {
  return SessionTable().Remove(session);
}
std::shared_ptr<HeldOptions> FindOptions(WaymarkOptions options) {
  return OptionsTable().Find(options);
}
std::shared_ptr<HeldSession> FindSession(WaymarkSession session) {
  return SessionTable().Find(session);
}

Outcome NoSuchOptions(WaymarkOptions options) {
  return {WAYMARK_NO_SUCH_HANDLE,
          fmt::format("options {}: there are none, or they are no more", options)};
}
Outcome NoSuchSession(WaymarkSession session) {
  return {WAYMARK_NO_SUCH_HANDLE,
          fmt::format("session {}: there is none, or it was destroyed", session)};
}

// Whole rooms are compared, so only when the device says that something changed.
Event NextEvent(HeldSession& session) {
  if (auto event = session.feed.Take()) return *std::move(event);
  DeviceSession& device = *session.device;
  for (const EditOutcome& edit : device.TakeOutcomes()) {
    const WaymarkStatus status = edit.error ? Outcome(*edit.error).status : WAYMARK_OK;
    session.feed.Tell({WAYMARK_EDIT_ENDED, status, edit.anchor.text()});
  }
  const std::uint64_t changes = device.Changes();
  if (session.compared_changes != changes) {
    session.compared_changes = changes;
    session.feed.Compare({.others = device.Others(),
                          .anchors = device.Anchors(),
                          .standing = device.Standing(),
                          .has_snapshot = device.HasSnapshot(),
                          .epoch = device.DescribeMap().epoch});
  }
  session.feed.Compare(device.Pose().state);
  return session.feed.Take().value_or(Event{});
}

}  // namespace waymark::session::c

// SPDX-License-Identifier: Apache-2.0
// The worker's half of a device session: what arrives.
#include "mapping/base/log.h"
#include "session/device/internal/live_session.h"

namespace waymark::session::internal {

void LiveSession::On(const wire::DeviceLink::Event& event) {
  if (const auto* message = std::get_if<wire::Downward>(&event)) {
    const bool is_quiet =
        std::holds_alternative<PoseBatch>(*message) || std::holds_alternative<ClockPong>(*message);
    if (!is_quiet) ++changes_;
    return std::visit([this](const auto& content) { On(content); }, *message);
  }
  ++changes_;
  using Link = wire::DeviceLink;
  if (const auto* lost = std::get_if<Link::DeviceLost>(&event)) return view_.OnLost(lost->device);
  if (const auto* lost = std::get_if<Link::AnchorLost>(&event)) {
    return view_.OnLost(lost->anchor, lost->is_own);
  }
  if (std::holds_alternative<Link::ToldAnew>(event)) return view_.BeginResync();
  join_.Restart(std::chrono::steady_clock::now());
  images_.Abandon();  // a newer one is better than one that may never be answered
}

void LiveSession::On(const Welcome& welcome) {
  const std::optional<Welcome> before = join_.welcome();
  const SessionMap map_before = CurrentMap();
  switch (join_.On(welcome, std::chrono::steady_clock::now())) {
    case JoinDesk::Outcome::kIgnored:
      return;
    case JoinDesk::Outcome::kRefused:
      refusal_ = welcome;
      if (welcome.verdict == JoinVerdict::kAccepted) {
        refusal_->verdict = JoinVerdict::kInvalid;
        refusal_->reason = fmt::format("expected a server of protocol {} or later, found {}",
                                       kOldestProtocol, welcome.protocol);
      }
      standing_.is_in = false;  // it asks again
      standing_.reason = refusal_->reason;
      FinishEdits(NotIn());
      return;
    case JoinDesk::Outcome::kRemoved:
      standing_.is_in = false;
      standing_.reason = welcome.reason;
      LogWarning("room {}: {}", options_.room.text(), welcome.reason);
      FinishEdits(NotIn());
      return;
    case JoinDesk::Outcome::kJoined:
      break;
  }
  bursts_.Forget();  // the server may, or may know the device by another ticket
  ++statistics_.joins;
  standing_.is_in = true;
  standing_.reason.clear();
  standing_.role = welcome.role;
  standing_.owner = welcome.owner;
  if (welcome.is_return) ++standing_.returns;
  if (map_before.id != welcome.map.map || map_before.epoch != welcome.map.epoch) {
    tracker_.Reset();  // the fixes, if any, are in the frame of another release
  }
  if (!before || before->run != welcome.run) {
    session_clock_.Clear();
    last_swap_ = 0;
  }
  images_.Abandon();  // what was asked before the silence may never be answered
  view_.StartRun(welcome.run, welcome.map.epoch);
  areas_.BeginAnew();
}

void LiveSession::On(const AreaState& state) {
  areas_.On(state, std::chrono::steady_clock::now());
  view_.On(state);
}

std::optional<Eigen::Vector2d> LiveSession::About() const {
  if (const auto pose = CurrentPose().map_from_device) return pose->translation().head<2>();
  const SessionMap map = CurrentMap();
  if (!about_ || !map.is_geo_aligned) return std::nullopt;
  return TangentPlane(map.origin).ToMap(*about_).coordinates().head<2>();
}

void LiveSession::SayArea(Instant now) {
  if (!join_.IsConnected() || !areas_.IsLookDue(now)) return;
  const auto position_m = About();
  if (!position_m) return;
  auto report = areas_.TakeDue(*position_m, view_.HasSnapshot(), now);
  if (!report) return;
  report->ticket = join_.welcome()->ticket;
  (void)link_->Send(*report);
}

void LiveSession::On(const wire::DeviceGone& gone) { view_.OnGone(gone.device, SessionNow()); }

void LiveSession::On(const MapState& state) {
  const auto& welcome = join_.welcome();
  if (!welcome || state.run != welcome->run || state.swap <= last_swap_) return;
  last_swap_ = state.swap;
  placements_ = state.placements;
  if (state.epoch == welcome->map.epoch) return;  // welcomed after it
  join_.SetEpoch(state.epoch);
  if (const auto motion = tracker_.CarryTo(state.placements)) {
    edits_.CarryBy(*motion, state.epoch);
  }
  view_.CarryTo(state.epoch, state.placements);
  ++statistics_.map_changes;
}

void LiveSession::On(const CommandReply& reply) {
  if (!commands_.On(reply)) return;
  const bool is_news =
      reply.outcome == CommandOutcome::kApplied || reply.outcome == CommandOutcome::kConflict;
  if (is_news && reply.current) view_.OnOwnChange(*reply.current);
  FinishEdit(reply.request);
}

void LiveSession::On(const ClockPong& pong) {
  join_.OnPong(pong, std::chrono::steady_clock::now());
  session_clock_.Add({.device_sent = pong.device_sent,
                      .server_received = pong.received,
                      .server_sent = pong.sent,
                      .device_received = SteadyNow()});
}

}  // namespace waymark::session::internal

// SPDX-License-Identifier: Apache-2.0
#include "session/server/publisher.h"

#include <algorithm>

#include "mapping/base/log.h"
#include "session/server/internal/log_failure.h"

namespace waymark::session {
namespace {

constexpr std::chrono::seconds kLastWords{5};      // a device's writers live on after its end
constexpr std::chrono::seconds kMemoryOfEnds{30};  // ten leases: who missed it has left
constexpr int kMaxRefusalsLogged = 5;              // in a second
constexpr std::size_t kMaxRefusedDevices = 512;    // so that they take no places from others
constexpr std::size_t kMaxOpenDevices = 4096;      // beyond it hellos are not answered

}  // namespace

void Publisher::Do(const effect::OpenRoom& effect, ServerTime) {
  LogFailure(bus_.OpenRoom(effect.room));
  audiences_.insert_or_assign(effect.room, Audience{PoseRelay(relay_options_), {}});
}

void Publisher::Do(const effect::CloseRoom& effect, ServerTime) {
  bus_.CloseRoom(effect.room);
  audiences_.erase(effect.room);
}

// A device that is refused asks again and again, and a hostile one as fast as it can.
void Publisher::Log(const RoomId& room, const Welcome& welcome, ServerTime now) {
  if (welcome.verdict == JoinVerdict::kAccepted) {
    ++counters_.joins;
    return;
  }
  const bool is_removal = welcome.verdict == JoinVerdict::kRemoved;
  ++(is_removal ? counters_.removals : counters_.refusals);
  if (now - log_second_ >= std::chrono::seconds(1)) {
    log_second_ = now;
    refusals_logged_ = 0;
  }
  if (++refusals_logged_ > kMaxRefusalsLogged) return;
  LogInfo("room {}: device {} {}: {}", room.text(), welcome.device.text(),
          is_removal ? "removed" : "refused", welcome.reason);
}

void Publisher::Do(const effect::SendWelcome& effect, ServerTime now) {
  const DeviceId& device = effect.welcome.device;
  const auto open = open_devices_.find(device);
  const bool is_refused = effect.welcome.verdict != JoinVerdict::kAccepted;
  // Who says its name without the right to it takes nothing from it.
  const bool has_moved = !is_refused && bus_.HasChangedItsWay(device);
  if (open == open_devices_.end() || open->second != effect.room || has_moved) {
    if (open_devices_.size() >= kMaxOpenDevices) return;
    if (is_refused && closing_devices_.size() >= kMaxRefusedDevices) return;
    owners_.Forget(device);
    const Result<void> opened = bus_.OpenDevice(effect.room, device);
    if (!opened.ok()) return LogFailure(opened);
    open_devices_.insert_or_assign(device, effect.room);
  }
  closing_devices_.erase(device);
  Log(effect.room, effect.welcome, now);
  if (effect.welcome.verdict == JoinVerdict::kAccepted) {
    const auto audience = audiences_.find(effect.room);
    if (audience != audiences_.end()) {
      audience->second.listeners.insert_or_assign(device,
                                                  PoseRelay::Listener(effect.welcome.number));
    }
  }
  LogFailure(bus_.Send(effect.welcome));
}

void Publisher::Do(const effect::CloseDevice& effect, ServerTime now) {
  // Or its return would begin with what held before it left.
  owners_.Forget(effect.device);
  areas_.Forget(effect.device);
  closing_devices_.insert_or_assign(effect.device, now);
  const auto open = open_devices_.find(effect.device);
  if (open == open_devices_.end()) return;
  const auto audience = audiences_.find(open->second);
  if (audience != audiences_.end()) audience->second.listeners.erase(effect.device);
}

void Publisher::Do(const effect::PublishPresence& effect, ServerTime) {
  withdrawn_devices_.erase({effect.room, effect.presence.device});
  LogFailure(bus_.Publish(effect.room, effect.presence));
}

void Publisher::Do(const effect::WithdrawPresence& effect, ServerTime now) {
  ++counters_.departures;
  withdrawn_devices_.insert_or_assign({effect.room, effect.device}, now);
  LogFailure(bus_.Withdraw(effect.room, effect.device));
}

void Publisher::Do(const effect::PublishPoses& effect, ServerTime now) {
  if (bus_.IsHeardByGateways(effect.room)) TellGateways(effect, now);
  TellDevices(effect, now);
}

// A gateway chooses for its phones itself.
void Publisher::TellGateways(const effect::PublishPoses& effect, ServerTime now) {
  const std::size_t count = effect.poses.size();
  PoseBatch batch{.chunk = 0,
                  .chunks = static_cast<std::uint32_t>((count - 1) / kMaxPosesPerBatch + 1),
                  .tick = effect.tick,
                  .epoch = effect.epoch,
                  .run = effect.run,
                  .time = now,
                  .poses = {}};
  for (; batch.chunk < batch.chunks; ++batch.chunk) {
    const auto begin = batch.chunk * kMaxPosesPerBatch;
    const auto end = std::min(count, begin + kMaxPosesPerBatch);
    batch.poses.assign(effect.poses.begin() + static_cast<std::ptrdiff_t>(begin),
                       effect.poses.begin() + static_cast<std::ptrdiff_t>(end));
    ++counters_.pose_batches;
    LogFailure(bus_.Publish(effect.room, batch));
  }
}

void Publisher::TellDevices(const effect::PublishPoses& effect, ServerTime now) {
  const auto audience = audiences_.find(effect.room);
  if (audience == audiences_.end()) return;
  PoseRelay& relay = audience->second.relay;
  relay.Hear(effect.epoch, effect.poses, now);
  relay.FinishHearing(effect.tick);
  PoseBatch batch{
      .tick = effect.tick, .epoch = effect.epoch, .run = effect.run, .time = now, .poses = {}};
  for (auto& [device, listener] : audience->second.listeners) {
    if (!bus_.HearsPoses(device)) continue;
    batch.poses.clear();
    for (const PoseRelay::Slot slot : relay.Choose(listener)) {
      batch.poses.push_back(relay.poses()[slot]);
    }
    if (batch.poses.empty()) continue;
    batch.time = clock_();
    ++counters_.pose_batches;
    LogFailure(bus_.Send(device, batch));
  }
}

void Publisher::Do(const effect::PublishAnchor& effect, ServerTime) {
  withdrawn_anchors_.erase({effect.room, effect.state.anchor.record.id});
  LogFailure(bus_.Publish(effect.room, effect.state));
}

void Publisher::Do(const effect::WithdrawAnchor& effect, ServerTime now) {
  withdrawn_anchors_.insert_or_assign({effect.room, effect.anchor}, now);
  LogFailure(bus_.Withdraw(effect.room, effect.anchor));
}

void Publisher::Do(const effect::PublishRoomState& effect, ServerTime) {
  LogFailure(bus_.Publish(effect.state.room, effect.state));
}

void Publisher::Do(const effect::PublishMapState& effect, ServerTime) {
  LogFailure(bus_.Publish(effect.state.room, effect.state));
}

void Publisher::Do(const effect::ReportSwap& effect, ServerTime) {
  LogInfo(
      "epoch {} is served: {} anchors of open rooms carried, by {:.3f} m at most; {} unsupported",
      effect.epoch, effect.carried, effect.max_motion_m, effect.unsupported);
}

void Publisher::Do(const effect::SendReply& effect, ServerTime) {
  // A device that left does not hear it; what it wanted is done all the same.
  (void)bus_.Send(effect.reply);
}

void Publisher::Tend(ServerTime now) {
  for (auto device = closing_devices_.begin(); device != closing_devices_.end();) {
    if (now - device->second < kLastWords) {
      ++device;
      continue;
    }
    bus_.CloseDevice(device->first);
    open_devices_.erase(device->first);
    device = closing_devices_.erase(device);
  }
  Forget(withdrawn_devices_, now);
  Forget(withdrawn_anchors_, now);
  owners_.Tend(now, kMemoryOfEnds);
  areas_.Tend(now, kMemoryOfEnds);
}

template <typename Key>
void Publisher::Forget(Withdrawn<Key>& withdrawn, ServerTime now) {
  for (auto entry = withdrawn.begin(); entry != withdrawn.end();) {
    if (now - entry->second < kMemoryOfEnds) {
      ++entry;
      continue;
    }
    bus_.Forget(entry->first.first, entry->first.second);
    entry = withdrawn.erase(entry);
  }
}

}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <csignal>

#include "examples/phone/replay.h"
#include "examples/phone/replay_json.h"
#include "examples/phone/tools/phone_flags.h"
#include "examples/phone/walk.h"
#include "mapping/base/file.h"
#include "mapping/base/log.h"

namespace {

using namespace waymark;  // NOLINT: a program, not a header

std::atomic<bool> stop_requested{false};

Result<void> Play(phone::Flags flags) {
  WAYMARK_TRY_ASSIGN(const phone::Walk walk, phone::LoadWalk(flags.walk));
  // The anchor goes straight ahead of the camera, upright in its image.
  const Transform<Camera, Anchor> camera_from_anchor(Eigen::Quaterniond::Identity(),
                                                     {0, 0, flags.anchor_distance_m});
  flags.replay.device_from_anchor = walk.device_from_camera * camera_from_anchor;
  WAYMARK_TRY_ASSIGN(const auto device, session::DeviceSession::Join(flags.device));
  LogInfo("{} joined room {} as {}", flags.device.name, flags.device.room.text(),
          device->id().text());
  WAYMARK_TRY_ASSIGN(const auto replay,
                     phone::ReplayWalk(walk, *device, flags.replay, stop_requested));
  const auto statistics = device->Statistics();
  LogInfo(
      "{}: {} fixes of {} keyframes, {} of them with earlier ones, {} by its tile, {} anchors "
      "known",
      flags.device.name, statistics.fixes, statistics.keyframes_sent, statistics.burst_fixes,
      statistics.tile_fixes, replay.anchors.size());
  const auto json = phone::EncodeReplay(replay, walk, flags.device.name, device->id(), statistics);
  device->Leave();
  return StoreFileAtomically(flags.out, std::string_view(json));
}

Result<void> Kick(const phone::Flags& flags) {
  WAYMARK_TRY_ASSIGN(const auto device, session::DeviceSession::Join(flags.device));
  WAYMARK_TRY(device->Kick(*flags.kick, flags.kick_reason));
  LogInfo("room {}: {} is sent away", flags.device.room.text(), flags.kick->text());
  device->Leave();
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  int exit_status = 0;
  const auto flags = phone::ParseFlags(argc, argv, exit_status);
  if (!flags) return exit_status;
  std::signal(SIGINT, [](int) { stop_requested = true; });
  std::signal(SIGTERM, [](int) { stop_requested = true; });
  if (const auto result = flags->kick ? Kick(*flags) : Play(*flags); !result) {
    LogError("waymark-phone: {}", ToString(result.error()));
    return 1;
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>

#include <atomic>
#include <csignal>

#include "examples/phone/replay.h"
#include "examples/phone/replay_json.h"
#include "examples/phone/walk.h"
#include "mapping/base/file.h"
#include "mapping/base/log.h"

namespace {

using namespace waymark;  // NOLINT: a program, not a header

std::atomic<bool> stop_requested{false};

struct Flags {
  std::string walk;
  std::string out;
  session::DeviceOptions device;
  std::string room = "lobby";
  std::string id;
  double keyframe_interval_s = 1;
  phone::ReplayOptions replay;
  double anchor_distance_m = 3;
};

Result<void> Run(Flags flags) {
  WAYMARK_TRY_ASSIGN(const phone::Walk walk, phone::LoadWalk(flags.walk));
  flags.device.room = RoomId(flags.room);
  if (!flags.id.empty()) flags.device.id = DeviceId(flags.id);
  flags.device.keyframe_interval = std::chrono::duration<double>(flags.keyframe_interval_s);
  // The anchor goes straight ahead of the camera, upright in its image.
  const Transform<Camera, Anchor> camera_from_anchor(Eigen::Quaterniond::Identity(),
                                                     {0, 0, flags.anchor_distance_m});
  flags.replay.device_from_anchor = walk.device_from_camera * camera_from_anchor;
  WAYMARK_TRY_ASSIGN(const auto device, session::DeviceSession::Join(flags.device));
  LogInfo("{} joined room {} as {}", flags.device.name, flags.room, device->id().text());
  WAYMARK_TRY_ASSIGN(const auto replay,
                     phone::ReplayWalk(walk, *device, flags.replay, stop_requested));
  const auto statistics = device->Statistics();
  LogInfo("{}: {} fixes of {} keyframes, {} anchors known", flags.device.name, statistics.fixes,
          statistics.keyframes_sent, replay.anchors.size());
  const auto json = phone::EncodeReplay(replay, walk, flags.device.name, device->id(), statistics);
  device->Leave();
  return StoreFileAtomically(flags.out, std::string_view(json));
}

}  // namespace

int main(int argc, char** argv) {
  Flags flags;
  CLI::App app{
      "Plays a recorded walk as a phone would live it: joins a room, sends keyframes, shares its\n"
      "pose, and writes what it believed. Example:\n"
      "  waymark-phone out/phones/1 --room lobby --place-anchor-after 15 --out phone1.json\n"};
  app.add_option("walk", flags.walk, "kapture folder with one camera and odometry")->required();
  app.add_option("--out", flags.out, "JSON file to write when the walk is over")->required();
  app.add_option("--server", flags.device.server,
                 "address of waymark-serve, or wss://HOST:PORT of a waymark-gateway")
      ->capture_default_str();
  app.add_option("--authority", flags.device.authority_file,
                 "PEM file of who vouches for the gateway; the system's authorities without it");
  app.add_option("--domain", flags.device.dds_domain, "DDS domain of the server")
      ->capture_default_str()
      ->check(CLI::Range(0, 230));
  app.add_option("--room", flags.room, "room to join")->capture_default_str();
  app.add_option(
         "--security", flags.device.security_folder,
         "folder of `waymark-keys issue KEYS device UUID`, for DDS that is secured; with --id")
      ->needs(app.add_option("--id", flags.id, "UUID to join as; a new one without it"));
  app.add_option("--token", flags.device.token, "lets it into the room; from waymark-keys token")
      ->envname("WAYMARK_TOKEN");
  app.add_option("--name", flags.device.name, "name shown to others")->capture_default_str();
  app.add_option("--keyframe-interval", flags.keyframe_interval_s, "seconds between keyframes")
      ->capture_default_str();
  app.add_option("--place-anchor-after", flags.replay.place_anchor_after_s,
                 "place an anchor this many seconds into the walk, once localised");
  app.add_option("--anchor-distance", flags.anchor_distance_m, "metres ahead of the camera")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  std::signal(SIGINT, [](int) { stop_requested = true; });
  std::signal(SIGTERM, [](int) { stop_requested = true; });
  if (const auto result = Run(flags); !result) {
    LogError("waymark-phone: {}", ToString(result.error()));
    return 1;
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "examples/phone/tools/phone_flags.h"

#include <CLI/CLI.hpp>

namespace waymark::phone {
namespace {

void AddJoining(CLI::App& app, session::DeviceOptions& device) {
  app.add_option("--server", device.server,
                 "address of waymark-serve, or wss://HOST:PORT of a waymark-gateway")
      ->capture_default_str();
  app.add_option("--authority", device.authority_file,
                 "PEM file of who vouches for the gateway; the system's authorities without it");
  app.add_option("--domain", device.dds_domain, "DDS domain of the server")
      ->capture_default_str()
      ->check(CLI::Range(0, 230));
  app.add_option("--slices", device.dds_slices, "into how many the server cuts its bus")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  app.add_option_function<std::string>(
      "--room", [&](const std::string& room) { device.room = RoomId(room); },
      "room to join, lobby without it");
  auto* const id = app.add_option_function<std::string>(
      "--id", [&](const std::string& text) { device.id = DeviceId(text); },
      "UUID to join as; a new one without it");
  app.add_option("--security", device.security_folder,
                 "folder of `waymark-keys issue KEYS device UUID`, for DDS that is secured")
      ->needs(id);
  app.add_option("--token", device.token, "lets it into the room; from waymark-keys token")
      ->envname("WAYMARK_TOKEN");
  app.add_option("--owner-secret", device.owner_secret,
                 "what all phones of one owner know: anchors of one belong to all")
      ->envname("WAYMARK_OWNER_SECRET");
  app.add_option("--anchor-radius", device.anchor_radius_m,
                 "anchors so near are told, metres; 0: all of the room")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 2000.0));
  app.add_option("--name", device.name, "name shown to others")->capture_default_str();
}

void AddLocalising(CLI::App& app, session::DeviceOptions& device) {
  app.add_option_function<double>(
      "--keyframe-interval",
      [&](double seconds) { device.keyframe_interval = std::chrono::duration<double>(seconds); },
      "seconds between keyframes, 1 without it");
  app.add_option("--tile", device.tile_folder,
                 "small map to localise against while the server is away, for example from\n"
                 "waymark-map summarise MAP --submap ID --max-mb 0.95 --out TILE")
      ->check(CLI::ExistingDirectory);
  app.add_option("--burst", device.burst_images,
                 "keyframes that are asked as one where the newest is not found alone")
      ->capture_default_str()
      ->check(CLI::Range(1, 16));
  app.add_option_function<int>(
      "--send-features",
      [&](int count) {
        device.keyframe_content = session::KeyframeContent::kFeatures;
        device.max_sent_features = count;
      },
      "sends so many features, [50, 2000], instead of pixels");
}

}  // namespace

std::optional<Flags> ParseFlags(int argc, char** argv, int& exit_status) {
  Flags flags;
  CLI::App app{
      "Plays a recorded walk as a phone would live it: joins a room, sends keyframes, shares its\n"
      "pose, and writes what it believed. Example:\n"
      "  waymark-phone out/phones/1 --room lobby --place-anchor-after 15 --out phone1.json\n"
      "As a moderator it may send a device away instead:\n"
      "  waymark-phone --room lobby --token TOKEN --kick UUID\n"};
  auto* const walk =
      app.add_option("walk", flags.walk, "kapture folder with one camera and odometry");
  auto* const out =
      app.add_option("--out", flags.out, "JSON file to write when the walk is over")->needs(walk);
  walk->needs(out);
  AddJoining(app, flags.device);
  AddLocalising(app, flags.device);
  app.add_option("--place-anchor-after", flags.replay.place_anchor_after_s,
                 "place an anchor this many seconds into the walk, once localised");
  app.add_option("--audience", flags.replay.audience,
                 "of the anchor: room, private (its owner's phones alone) or public")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, content::AnchorVisibility>{
              {"room", content::AnchorVisibility::kRoom},
              {"private", content::AnchorVisibility::kPrivate},
              {"public", content::AnchorVisibility::kPublic}},
          CLI::ignore_case));
  app.add_option("--anchor-distance", flags.anchor_distance_m, "metres ahead of the camera")
      ->capture_default_str();
  auto* const kick = app.add_option_function<std::string>(
      "--kick", [&](const std::string& device) { flags.kick = DeviceId(device); },
      "UUID of a device to send away");
  kick->excludes(walk);
  app.add_option("--reason", flags.kick_reason, "why, told to it")->needs(kick);
  try {
    app.parse(argc, argv);
    if (!*kick && !*walk) throw CLI::RequiredError("walk and --out, or --kick");
  } catch (const CLI::ParseError& error) {
    exit_status = app.exit(error);
    return std::nullopt;
  }
  return flags;
}

}  // namespace waymark::phone

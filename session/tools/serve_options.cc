// SPDX-License-Identifier: Apache-2.0
#include "session/tools/serve_options.h"

#include <map>

#include "session/tools/security.h"

namespace waymark::session {
namespace {

void AddSecurityOptions(CLI::App& app, ServeArguments& arguments) {
  const std::map<std::string, Role> roles{
      {"viewer", Role::kViewer}, {"member", Role::kMember}, {"moderator", Role::kModerator}};
  app.add_option("--security", arguments.security,
                 "Folder of waymark-keys: devices must show a token for their room; one of "
                 "`waymark-keys issue` also has DDS authenticated and encrypted");
  app.add_flag("--insecure", arguments.is_insecure_wanted,
               "Serve beyond this machine without keys: whoever reaches the ports may do all");
  app.add_option("--open-role", arguments.server.open_role,
                 "What everybody is where no tokens are asked for: viewer, member or moderator")
      ->transform(CLI::CheckedTransformer(roles, CLI::ignore_case))
      ->default_str("member");
  app.add_flag_callback(
      "--moderators-open",
      [&arguments] { arguments.server.state.opening = RoomOpening::kModerators; },
      "A room is open to others once a moderator is in it");
  app.add_option("--room-capacity", arguments.server.state.max_members,
                 "Devices that a room holds at most; moderators may set less")
      ->capture_default_str();
  app.add_option("--rules", arguments.server.rules_file,
                 "File in which what moderators decide outlives the server; default: STORE.rules "
                 "where the store is a file");
  app.add_flag_callback(
      "--only-owners", [&arguments] { arguments.server.state.rights = AnchorRights::kOwner; },
      "Anchors may be moved and deleted by their owner and by moderators alone");
}

}  // namespace

void AddServeOptions(CLI::App& app, ServeArguments& arguments) {
  app.footer(
      "Examples:\n"
      "  waymark-serve --map MAP --store anchors.db                       on this machine, open\n"
      "  waymark-serve --map MAP --store anchors.db --security KEYS       with tokens\n"
      "  waymark-serve … --address 192.0.2.7 --security KEYS/issued/main  for others, encrypted\n"
      "Keys and tokens come from `waymark-serve keys …`, which is also waymark-keys.");
  app.add_option("--map", arguments.map, "Map folder with a deployed release")->required();
  app.add_option("--store", arguments.store,
                 "Anchor store, created if absent: a file, or postgresql://user@host/database, "
                 "which several servers may share")
      ->required();
  app.add_option("--domain", arguments.server.dds_domain, "DDS domain, 0 to 230")
      ->capture_default_str();
  app.add_option("--slices", arguments.server.slices,
                 "Cut the bus into so many, 1 to 64, where hundreds of devices come without a "
                 "gateway: those in other slices' rooms cost a device nothing. UDP ports 7410 + "
                 "250 domain and up, two to a slice; devices and gateways must be told the same")
      ->capture_default_str();
  app.add_option("--address", arguments.server.address, "Address of the interface to serve on")
      ->capture_default_str();
  app.add_option("--frame-rate", arguments.server.frame_hz, "Pose batches per second to each phone")
      ->capture_default_str();
  app.add_option("--threads", arguments.server.localise.threads, "Images localised at once")
      ->capture_default_str();
  app.add_option("--localiser-memory-mb", arguments.localiser_memory_mb,
                 "Budget of submaps in memory, in 10^6 bytes; 0: all of them. What is asked for "
                 "and is not there is opened, and that image waits")
      ->check(CLI::Range(0.0, 1e9))
      ->capture_default_str();
  app.add_option("--record", arguments.server.recording_file,
                 "New file for all that enters the session; waymark-replay takes it up");
  app.add_option(
      "--keep-queries", arguments.kept_queries.folder,
      "Folder for a sample of phones' images, spread over the map; waymark-rehearse asks "
      "a new release about them");
  app.add_option("--queries-per-place", arguments.kept_queries.per_cell,
                 "Kept of each 50 m square, the newest")
      ->capture_default_str();
  AddSecurityOptions(app, arguments);
}

std::string RulesFile(const ServeArguments& arguments) {
  const std::string& chosen = arguments.server.rules_file;
  if (!chosen.empty() || content::IsPostgresLocation(arguments.store)) return chosen;
  return arguments.store + ".rules";
}

Result<void> CheckSecurity(const ServeArguments& arguments) {
  const std::string& address = arguments.server.address;
  const bool has_credentials = HasDdsCredentials(arguments.security);
  if (IsLoopback(address) || has_credentials || arguments.is_insecure_wanted) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "address {}: others can reach it; expected --security with a folder of "
                   "`waymark-keys issue KEYS server NAME`, or --insecure to serve everybody",
                   address);
}

}  // namespace waymark::session

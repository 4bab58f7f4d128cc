// SPDX-License-Identifier: Apache-2.0
#include "session/tools/key_commands.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <string>

#include "mapping/base/log.h"
#include "session/keys/authority.h"
#include "session/keys/expiry.h"

namespace waymark::session {
namespace {

using keys::Authority;

struct Arguments {
  std::filesystem::path folder;
  std::string room = "lobby", role = "member", device;
  double hours = 0;  // 0: as fits
  std::string what, id;
  std::filesystem::path out;
  bool is_renewal = false;
};

Result<void> Init(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const Authority authority, Authority::Create(arguments.folder));
  fmt::print("{}: made; {}/secret stays on this machine\n", arguments.folder.string(),
             authority.folder().string());
  return {};
}

Result<void> Token(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const Authority authority, Authority::Open(arguments.folder));
  keys::TokenClaims claims{.room = RoomId(arguments.room), .issued = keys::WallNow()};
  claims.role = *FindRole(arguments.role);
  if (!arguments.device.empty()) claims.device = DeviceId(arguments.device);
  claims.expires = claims.issued + std::chrono::seconds(static_cast<std::int64_t>(
                                       3600 * (arguments.hours > 0 ? arguments.hours : 12)));
  const keys::WallTime expires = claims.expires;
  WAYMARK_TRY_ASSIGN(const Authority::Issued issued, authority.IssueToken(std::move(claims)));
  fmt::print("{}\n", issued.token);
  fmt::print(stderr, "token {}: {} of room {} until {:%Y-%m-%d %H:%M:%S} UTC\n", issued.id,
             arguments.role, arguments.room, expires);
  return {};
}

Result<void> Issue(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const Authority authority, Authority::Open(arguments.folder));
  using Kind = Authority::Request::Kind;
  const bool is_device = arguments.what == "device";
  const double hours = arguments.hours > 0 ? arguments.hours : is_device ? 12 : 24 * 90;
  const keys::WallTime now = keys::WallNow();
  Authority::Request request{
      .kind = is_device                     ? Kind::kDevice
              : arguments.what == "gateway" ? Kind::kGateway
                                            : Kind::kServer,
      .name = arguments.id,
      .room = arguments.room,
      .validity = {now - std::chrono::minutes(5),  // clocks differ
                   now + std::chrono::seconds(static_cast<std::int64_t>(3600 * hours))},
      .out = arguments.out,
      .is_renewal = arguments.is_renewal};
  WAYMARK_TRY_ASSIGN(const auto folder, authority.Issue(request));
  fmt::print("{}\n", folder.string());
  fmt::print(stderr, "{} {} until {:%Y-%m-%d %H:%M:%S} UTC\n", arguments.what, arguments.id,
             request.validity.until);
  return {};
}

Result<void> Show(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const auto endings, keys::ListEndings(arguments.folder));
  if (endings.empty()) {
    return MakeError(ErrorCode::kNotFound,
                     "{}: expected a folder of `waymark-keys init` or `issue`",
                     arguments.folder.string());
  }
  for (const keys::Ending& ending : endings) {
    const auto days = std::chrono::floor<std::chrono::days>(ending.until - keys::WallNow()).count();
    fmt::print("{:%Y-%m-%d %H:%M:%S} UTC  {:>9}  {}  ({})\n", ending.until,
               ending.until > keys::WallNow() ? fmt::format("{} days", days) : "ended",
               ending.file.string(), ending.name);
  }
  return {};
}

Result<void> Rotate(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(Authority authority, Authority::Open(arguments.folder));
  return authority.ChangeTokenKey();
}

Result<void> Revoke(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const Authority authority, Authority::Open(arguments.folder));
  return authority.Revoke(arguments.what, arguments.id);
}

using Command = Result<void> (*)(const Arguments&);

CLI::App* AddCommand(CLI::App& app, const char* name, const char* help, Arguments& arguments,
                     Command command, Command& chosen) {
  CLI::App* const added = app.add_subcommand(name, help);
  added->add_option("folder", arguments.folder, "of the keys")->required();
  added->callback([command, &chosen] { chosen = command; });
  return added;
}

void ParseArguments(CLI::App& app, Arguments& arguments, Command& chosen) {
  app.require_subcommand(1);
  app.footer(
      "Examples:\n"
      "  waymark-keys init KEYS\n"
      "  waymark-keys issue KEYS server main\n"
      "  waymark-serve --map MAP --store anchors.db --security KEYS/issued/main\n"
      "  waymark-keys show KEYS                                what ends when\n"
      "  waymark-keys issue KEYS server main --renew\n"
      "  waymark-keys token KEYS --room square --role moderator --hours 8\n"
      "  waymark-keys revoke KEYS token 0123456789abcdef     known everywhere within seconds");
  AddCommand(app, "init", "Makes the keys of a service", arguments, &Init, chosen);
  CLI::App* const token = AddCommand(app, "token", "Prints a token that lets a device into a room",
                                     arguments, &Token, chosen);
  token->add_option("--room", arguments.room, "it is good for")->capture_default_str();
  token
      ->add_option("--role", arguments.role,
                   "viewer: sees; member: also writes; moderator: also removes devices")
      ->capture_default_str()
      ->check(CLI::IsMember({"viewer", "member", "moderator"}));
  token->add_option("--device", arguments.device, "UUID that alone may use it; any without it");
  token->add_option("--hours", arguments.hours, "it is good for; 12 without it")
      ->check(CLI::Range(0.01, 24.0 * 366));
  CLI::App* const issue = AddCommand(
      app, "issue", "Makes a folder for DDS Security: --security of a server, gateway or device",
      arguments, &Issue, chosen);
  issue->add_option("kind", arguments.what, "server, gateway or device")
      ->required()
      ->check(CLI::IsMember({"server", "gateway", "device"}));
  issue->add_option("name", arguments.id, "of a server or gateway; UUID of a device")->required();
  issue->add_option("--room", arguments.room, "that a device may enter")->capture_default_str();
  issue
      ->add_option("--hours", arguments.hours,
                   "it is good for; without it 12 for a device, else 90 days")
      ->check(CLI::Range(0.01, 24.0 * 366));
  issue->add_option("--out", arguments.out, "folder; KEYS/issued/NAME without it");
  issue->add_flag("--renew", arguments.is_renewal,
                  "replaces what the folder holds; taken up when its server or gateway starts");
  AddCommand(app, "show",
             "Prints what ends when: of the keys and all that they issued, or of an "
             "issued folder",
             arguments, &Show, chosen);
  AddCommand(app, "rotate", "Has a new key sign tokens from now on", arguments, &Rotate, chosen);
  CLI::App* const revoke = AddCommand(
      app, "revoke", "Ends a token, all of a device, all that a key signed, or a gateway",
      arguments, &Revoke, chosen);
  revoke->add_option("what", arguments.what)
      ->required()
      ->check(CLI::IsMember({"token", "device", "key", "gateway"}));
  revoke->add_option("id", arguments.id)->required();
}

}  // namespace

int RunKeyCommand(int argc, char** argv, const std::string& program) {
  CLI::App app{"Makes the keys of a service and the tokens that let devices into its rooms.",
               program};
  Arguments arguments;
  Command chosen = nullptr;
  ParseArguments(app, arguments, chosen);
  CLI11_PARSE(app, argc, argv);
  const auto done = chosen(arguments);
  if (done.ok()) return 0;
  LogError("{}", ToString(done.error()));
  return 1;
}

}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
// waymark-serve: serves a map and its anchors until it is told to end. `waymark-serve keys …` is
// waymark-keys.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "content_store/anchor_store.h"
#include "mapping/base/log.h"
#include "session/server/map_localiser.h"
#include "session/server/release_watcher.h"
#include "session/server/server.h"
#include "session/tools/end_signals.h"
#include "session/tools/key_commands.h"
#include "session/tools/security.h"
#include "session/tools/serve_options.h"

namespace waymark::session {
namespace {

/// One server at a time serves an object, which a lock file beside or in it says.
Result<FileLock> LockServed(const std::filesystem::path& served,
                            const std::filesystem::path& lock) {
  Result<FileLock> acquired = FileLock::Acquire(lock, "waymark-serve");
  if (acquired.ok() || acquired.error().code != ErrorCode::kConflict) return acquired;
  return MakeError(ErrorCode::kConflict, "{}: is being served by another waymark-serve",
                   served.string());
}

/// A file is one server's; a database may be several servers'.
Result<std::optional<FileLock>> LockStore(const std::string& store) {
  if (content::IsPostgresLocation(store)) return std::optional<FileLock>();
  WAYMARK_TRY_ASSIGN(FileLock lock, LockServed(store, store + ".serve.lock"));
  return std::optional(std::move(lock));
}

/// Null: everybody may come.
Result<std::unique_ptr<keys::TokenDoor>> OpenDoor(const std::string& folder) {
  if (folder.empty()) return std::unique_ptr<keys::TokenDoor>();
  return keys::TokenDoor::Open({.folder = folder});
}

/// Null: no questions are kept.
Result<std::shared_ptr<QueryKeeper>> OpenKeeper(const ServeArguments& arguments,
                                                const mapping::MapDescription& map) {
  if (arguments.kept_queries.folder.empty()) return std::shared_ptr<QueryKeeper>();
  return QueryKeeper::Open(arguments.kept_queries, map);
}

Result<void> Serve(const ServeArguments& arguments, const sigset_t& end_signals) {
  WAYMARK_TRY(arguments.server.Validate());
  WAYMARK_TRY(CheckSecurity(arguments));
  ServerOptions options = arguments.server;
  if (HasDdsCredentials(arguments.security)) options.security_folder = arguments.security;
  keys::ExpiryWatch expiry(options.security_folder, "server");
  WAYMARK_TRY(expiry.CheckNow(keys::WallNow()));
  options.rules_file = RulesFile(arguments);
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(arguments.map));
  WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
  WAYMARK_TRY_ASSIGN(const auto store_lock, LockStore(arguments.store));
  WAYMARK_TRY_ASSIGN(const FileLock map_lock, LockServed(map.folder(), map.ServeLockPath()));
  WAYMARK_TRY_ASSIGN(auto door, OpenDoor(arguments.security));
  WAYMARK_TRY_ASSIGN(auto store, content::OpenStore(arguments.store));
  const localiser::LocaliserOptions localising{
      .memory_budget_bytes = static_cast<std::size_t>(1e6 * arguments.localiser_memory_mb)};
  WAYMARK_TRY_ASSIGN(const auto localiser, localiser::Localiser::Create(map, release, localising));
  WAYMARK_TRY_ASSIGN(const auto keeper, OpenKeeper(arguments, map.description()));
  const auto unfound = std::make_shared<UnfoundImages>();
  const MakeLocalise make_localise = [&](std::shared_ptr<const localiser::Localiser> opened) {
    return Observed(MakeLocaliseFunction(std::move(opened), map.description(), unfound), keeper);
  };
  WAYMARK_TRY_ASSIGN(
      const auto server,
      Server::Start(options,
                    {.map = map.description(),
                     .served = {release, make_localise(localiser)},
                     .store = std::move(store),
                     .load_release = [map](std::uint64_t epoch) { return map.LoadRelease(epoch); },
                     .door = std::move(door)}));
  fmt::print("ready pid={} domain={} address={} map={} epoch={} submaps={} tokens={}\n", ::getpid(),
             arguments.server.dds_domain, arguments.server.address, map.description().id,
             release.epoch, release.submaps.size(), arguments.security.empty() ? "no" : "yes");
  std::fflush(stdout);
  {
    const ReleaseWatcher watcher(map, localiser, make_localise, *server);
    AwaitSignal(end_signals, [&] { WarnOfExpiry(expiry); });
  }
  fmt::print("ended: {}\n", ToString(server->Stop()));
  return {};
}

}  // namespace
}  // namespace waymark::session

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "keys") {
    return waymark::session::RunKeyCommand(argc - 1, argv + 1, "waymark-serve keys");
  }
  const sigset_t end_signals = waymark::session::BlockEndSignals();
  CLI::App app{"Serves a map to devices: localisation, presence, poses and anchors.",
               "waymark-serve"};
  waymark::session::ServeArguments arguments;
  waymark::session::AddServeOptions(app, arguments);
  CLI11_PARSE(app, argc, argv);
  const auto served = waymark::session::Serve(arguments, end_signals);
  if (served.ok()) return 0;
  waymark::LogError("{}", waymark::ToString(served.error()));
  return 1;
}

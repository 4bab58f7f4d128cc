// SPDX-License-Identifier: Apache-2.0
// waymark-serve: serves a map and its anchors until it is told to end.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "content_store/anchor_store.h"
#include "mapping/base/log.h"
#include "session/server/map_localiser.h"
#include "session/server/release_watcher.h"
#include "session/server/server.h"
#include "session/tools/end_signals.h"

namespace waymark::session {
namespace {

struct Arguments {
  std::filesystem::path map;
  std::string store;
  bool only_owners = false;
  ServerOptions server;
};

void ParseArguments(CLI::App& app, Arguments& arguments) {
  app.add_option("--map", arguments.map, "Map folder with a deployed release")->required();
  app.add_option("--store", arguments.store,
                 "Anchor store, created if absent: a file, or postgresql://user@host/database, "
                 "which several servers may share")
      ->required();
  app.add_option("--domain", arguments.server.dds_domain, "DDS domain, 0 to 230")
      ->capture_default_str();
  app.add_option("--address", arguments.server.address, "Address of the interface to serve on")
      ->capture_default_str();
  app.add_option("--tick", arguments.server.tick_hz, "Pose batches per second")
      ->capture_default_str();
  app.add_option("--threads", arguments.server.localise.threads, "Images localised at once")
      ->capture_default_str();
  app.add_flag("--only-owners", arguments.only_owners,
               "Anchors may be moved and deleted by their owner alone");
}

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

Result<void> Serve(const Arguments& arguments, const sigset_t& end_signals) {
  WAYMARK_TRY(arguments.server.Validate());
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(arguments.map));
  WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
  WAYMARK_TRY_ASSIGN(const auto store_lock, LockStore(arguments.store));
  WAYMARK_TRY_ASSIGN(const FileLock map_lock, LockServed(map.folder(), map.ServeLockPath()));
  WAYMARK_TRY_ASSIGN(auto store, content::OpenStore(arguments.store));
  WAYMARK_TRY_ASSIGN(const auto localiser, localiser::Localiser::Create(map, release, {}));
  WAYMARK_TRY_ASSIGN(
      const auto server,
      Server::Start(
          arguments.server,
          {.map = map.description(),
           .served = {release, MakeLocaliseFunction(localiser, map.description())},
           .store = std::move(store),
           .load_release = [map](std::uint64_t epoch) { return map.LoadRelease(epoch); }}));
  fmt::print("ready pid={} domain={} address={} map={} epoch={} submaps={}\n", ::getpid(),
             arguments.server.dds_domain, arguments.server.address, map.description().id,
             release.epoch, release.submaps.size());
  std::fflush(stdout);
  {
    const ReleaseWatcher watcher(map, localiser, *server);
    AwaitSignal(end_signals);
  }
  fmt::print("ended: {}\n", ToString(server->Stop()));
  return {};
}

}  // namespace
}  // namespace waymark::session

int main(int argc, char** argv) {
  const sigset_t end_signals = waymark::session::BlockEndSignals();
  CLI::App app{"Serves a map to devices: localisation, presence, poses and anchors.",
               "waymark-serve"};
  waymark::session::Arguments arguments;
  waymark::session::ParseArguments(app, arguments);
  CLI11_PARSE(app, argc, argv);
  if (arguments.only_owners) {
    arguments.server.state.rights = waymark::session::AnchorRights::kOwner;
  }
  const auto served = waymark::session::Serve(arguments, end_signals);
  if (served.ok()) return 0;
  waymark::LogError("{}", waymark::ToString(served.error()));
  return 1;
}

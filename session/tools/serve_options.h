// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "session/rehearsal/query_keeper.h"
#include "session/server/server.h"

namespace waymark::session {

/// What waymark-serve is told on its command line.
struct ServeArguments {
  std::filesystem::path map;
  std::string store;
  std::string security;  ///< folder of keys; empty: none
  bool is_insecure_wanted = false;
  QueryKeeperOptions kept_queries;  ///< no folder: none are
  double localiser_memory_mb = 0;   ///< of submaps in memory, in 10^6 bytes; 0: no limit
  ServerOptions server;
};

/// Declares the options on the app; the arguments are set when it parses.
void AddServeOptions(CLI::App& app, ServeArguments& arguments);

/// Where what moderators decide is kept; empty: nowhere.
std::string RulesFile(const ServeArguments& arguments);

/// A service that others can reach is not left open by oversight.
Result<void> CheckSecurity(const ServeArguments& arguments);

}  // namespace waymark::session

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "mapping/base/result.h"

namespace CLI {
class App;
}

namespace waymark::mapping {

/// Exit codes of waymark-map; those from 64 on are sysexits.h's.
enum ExitCode : int {
  kDone = 0,
  kNothingAccepted = 1,  ///< all was well-formed, but nothing entered the map
  kBadUsage = 64,
  kBadData = 65,
  kNoInput = 66,
  kUnavailable = 69,
  kConflict = 73,
  kTryAgain = 75,  ///< of build-submap: not decided, and not because of its input
  kInterrupted = 130,
};

int ExitCodeOf(const Error& error);

/// Adds one subcommand to the program; its exit code is written to `exit_code` when it runs.
void RegisterAdd(CLI::App& app, int& exit_code);
void RegisterBuildSubmap(CLI::App& app, int& exit_code);
void RegisterInfo(CLI::App& app, int& exit_code);
void RegisterReport(CLI::App& app, int& exit_code);
void RegisterRemove(CLI::App& app, int& exit_code);
void RegisterPrune(CLI::App& app, int& exit_code);
void RegisterReleases(CLI::App& app, int& exit_code);  ///< releases, deploy, rollback
void RegisterDiff(CLI::App& app, int& exit_code);
void RegisterDraw(CLI::App& app, int& exit_code);
void RegisterSummarise(CLI::App& app, int& exit_code);
void RegisterImport(CLI::App& app, int& exit_code);
void RegisterExport(CLI::App& app, int& exit_code);

/// Prints a failed command's error as one sentence; returns the exit code.
int Finish(const Result<void>& outcome);

/// Now, ISO 8601 in UTC.
std::string UtcNow();

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "mapping/base/result.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content {

/// A PostgreSQL server of this process alone, in a temporary folder, on a Unix socket there. Runs
/// as the user "postgres" if we are root, which PostgreSQL refuses to be.
class PostgresServer {
 public:
  /// Errors: NotFound if the server's programs or an unprivileged user are absent.
  static Result<std::unique_ptr<PostgresServer>> Start();

  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;
  ~PostgresServer();

  /// The server's one database: a second one costs a second.
  std::string Uri() const;
  /// Runs SQL of a test, past the store.
  Result<void> Execute(const std::string& statements) const;
  /// The same; what the last statement answered in its first row and column.
  Result<std::string> Ask(const std::string& statements) const;
  /// Shuts down in order, lets `change` have the data directory, and starts.
  Result<void> ChangeFiles(const std::function<void(const std::filesystem::path& data)>& change);
  /// "Immediate" shutdown: as after a crash, nothing is flushed; then a start with recovery.
  Result<void> CrashAndRestart();

 private:
  PostgresServer(std::filesystem::path programs, std::filesystem::path folder);

  Result<void> Initialise();
  Result<void> Launch();
  void Stop(int signal);
  /// Starts a program as the server's user.
  pid_t Spawn(const std::string& program, const std::vector<std::string>& arguments) const;
  const std::filesystem::path programs_;
  const std::filesystem::path folder_;
  pid_t server_ = -1;
};

/// The server that all tests of this process share; absent where it cannot run, with the reason.
const Result<std::unique_ptr<PostgresServer>>& SharedPostgres();

}  // namespace waymark::content

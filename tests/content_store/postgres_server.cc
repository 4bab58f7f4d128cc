// SPDX-License-Identifier: Apache-2.0
#include "tests/content_store/postgres_server.h"

#include <fcntl.h>
#include <grp.h>
#include <libpq-fe.h>
#include <pwd.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

namespace waymark::content {
namespace {

namespace fs = std::filesystem;

/// Where Debian keeps the newest server's programs.
fs::path FindPrograms() {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& version : fs::directory_iterator("/usr/lib/postgresql", ignored)) {
    const fs::path programs = version.path() / "bin";
    if (fs::exists(programs / "initdb") && fs::exists(programs / "postgres")) {
      found.push_back(programs);
    }
  }
  return found.empty() ? fs::path() : *std::max_element(found.begin(), found.end());
}

int WaitFor(pid_t child) {
  int status = 0;
  return ::waitpid(child, &status, 0) == child && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

PostgresServer::PostgresServer(fs::path programs, fs::path folder)
    : programs_(std::move(programs)), folder_(std::move(folder)) {}

Result<std::unique_ptr<PostgresServer>> PostgresServer::Start() {
  const fs::path programs = FindPrograms();
  if (programs.empty()) {
    return MakeError(ErrorCode::kNotFound,
                     "PostgreSQL's server programs are not installed (package postgresql)");
  }
  if (::geteuid() == 0 && ::getpwnam("postgres") == nullptr) {
    return MakeError(ErrorCode::kNotFound, "there is no user \"postgres\" to run the server as");
  }
  std::string folder = "/tmp/waymark-pg-XXXXXX";  // short: a socket's path has 107 bytes
  if (::mkdtemp(folder.data()) == nullptr) {
    return MakeError(ErrorCode::kUnavailable, "{}: cannot create", folder);
  }
  std::unique_ptr<PostgresServer> server(new PostgresServer(programs, folder));
  WAYMARK_TRY(server->Initialise());
  WAYMARK_TRY(server->Launch());
  return server;
}

PostgresServer::~PostgresServer() {
  Stop(SIGQUIT);  // nothing is to be kept
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

pid_t PostgresServer::Spawn(const std::string& program,
                            const std::vector<std::string>& arguments) const {
  const std::string path = programs_ / program, log = folder_ / "log";
  std::vector<char*> argv{const_cast<char*>(path.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const passwd* const user = ::geteuid() == 0 ? ::getpwnam("postgres") : nullptr;
  const pid_t child = ::fork();
  if (child != 0) return child;
  ::prctl(PR_SET_PDEATHSIG, SIGINT);  // no server outlives a test that was killed
  const int output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  for (int descriptor = 3; descriptor < 256; ++descriptor) ::close(descriptor);
  const bool is_unprivileged =
      user == nullptr ||
      (::setgroups(0, nullptr) == 0 && ::setgid(user->pw_gid) == 0 && ::setuid(user->pw_uid) == 0);
  if (is_unprivileged && ::chdir(folder_.c_str()) == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGINT);  // a change of user clears it
    ::execv(argv[0], argv.data());
  }
  ::_exit(127);
}

Result<void> PostgresServer::Initialise() {
  if (::geteuid() == 0) {
    const passwd* const user = ::getpwnam("postgres");
    (void)::chown(folder_.c_str(), user->pw_uid, user->pw_gid);
  }
  const int status =
      WaitFor(Spawn("initdb", {"-D", (folder_ / "data").string(), "-A", "trust", "-U", "waymark",
                               "-E", "UTF8", "--locale=C.UTF-8", "--data-checksums", "--no-sync"}));
  if (status == 0) return {};
  return MakeError(ErrorCode::kUnavailable, "initdb: expected exit status 0, found {}", status);
}

Result<void> PostgresServer::Launch() {
  server_ = Spawn("postgres", {"-D", (folder_ / "data").string(), "-k", folder_.string(), "-c",
                               "listen_addresses=", "-c", "max_connections=120"});
  for (;;) {  // recovery takes what it takes; a server that gave up is noticed
    if (PQping(Uri().c_str()) == PQPING_OK) return {};
    int status = 0;
    if (::waitpid(server_, &status, WNOHANG) == server_) {
      server_ = -1;
      return MakeError(ErrorCode::kUnavailable, "postgres: ended by itself, status {}", status);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void PostgresServer::Stop(int signal) {
  if (server_ < 0) return;
  ::kill(server_, signal);
  (void)WaitFor(std::exchange(server_, -1));
}

Result<void> PostgresServer::CrashAndRestart() {
  Stop(SIGQUIT);
  return Launch();
}

std::string PostgresServer::Uri() const {
  return fmt::format("postgresql://waymark@/postgres?host={}", folder_.string());
}

Result<void> PostgresServer::ChangeFiles(const std::function<void(const fs::path&)>& change) {
  Stop(SIGINT);
  change(folder_ / "data");
  return Launch();
}

Result<void> PostgresServer::Execute(const std::string& statements) const {
  WAYMARK_TRY(Ask(statements));
  return {};
}

Result<std::string> PostgresServer::Ask(const std::string& statements) const {
  PGconn* const connection = PQconnectdb(Uri().c_str());
  PGresult* const result =
      PQexec(connection, ("SET client_min_messages = warning;" + statements).c_str());
  const ExecStatusType status = PQresultStatus(result);
  const std::string message = PQerrorMessage(connection);
  const std::string answer = PQntuples(result) > 0 ? PQgetvalue(result, 0, 0) : "";
  PQclear(result);
  PQfinish(connection);
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return answer;
  return MakeError(ErrorCode::kUnavailable, "{}", message);
}

const Result<std::unique_ptr<PostgresServer>>& SharedPostgres() {
  static const auto kServer = PostgresServer::Start();
  return kServer;
}

}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_session.h"

#include <poll.h>
#include <soci/postgresql/soci-postgresql.h>

#include <string_view>

#include "content_store/internal/postgres_schema.h"

namespace waymark::content::internal {
namespace {

/// SQLSTATE classes by what a caller can do about them.
ErrorCode CodeOf(std::string_view state) {
  if (state == "22012") return ErrorCode::kConflict;  // a division by zero: `wm_require`
  const std::string_view kind = state.substr(0, 2);
  // XX: internal error, data and index corruption; 42: a table or column is not what it was;
  // 23: a key exists twice that our counter gives once.
  if (kind == "XX" || kind == "42" || kind == "23") return ErrorCode::kCorrupt;
  return ErrorCode::kUnavailable;  // connection, resources, shutdown, locks, timeouts
}

/// Libpq's messages end lines where ours go on.
std::string OneLine(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (char& c : text) c = c == '\n' ? ' ' : c;
  return text;
}

}  // namespace

std::string PublicName(const std::string& uri) {
  std::string name = uri.substr(0, uri.find('?'));  // options may hold a password too
  const std::size_t begin = name.find("//");
  const std::size_t at = name.find('@');
  if (begin == std::string::npos || at == std::string::npos) return name;
  const std::size_t colon = name.find(':', begin + 2);
  if (colon < at) name.erase(colon, at - colon);
  return name;
}

Error DescribePostgres(const std::string& name, const std::exception& exception) {
  const auto* from_postgres = dynamic_cast<const soci::postgresql_soci_error*>(&exception);
  const std::string state = from_postgres != nullptr ? from_postgres->sqlstate() : "08000";
  return MakeError(CodeOf(state), "{}: {}", name, OneLine(exception.what()));
}

PostgresSession::PostgresSession(const std::string& uri, const std::string& name)
    : name_(name), sql_(soci::postgresql, uri) {
  // What libpq would print beside our own messages.
  PQsetNoticeProcessor(
      native(), [](void*, const char*) {}, nullptr);
}

PGconn* PostgresSession::native() {
  return static_cast<soci::postgresql_session_backend*>(sql_.get_backend())->conn_;
}

Result<std::unique_ptr<PostgresSession>> PostgresSession::Open(const std::string& uri,
                                                               const StoreOptions& options) {
  WAYMARK_TRY(options.Validate());
  const std::string name = PublicName(uri);
  try {
    std::unique_ptr<PostgresSession> session(new PostgresSession(uri, name));
    soci::session& sql = session->sql_;
    sql << "SET synchronous_commit = on";
    sql << "SET client_encoding = 'UTF8'";
    sql << "SET client_min_messages = warning";
    sql << fmt::format("SET lock_timeout = '{}s'", options.busy_timeout_s);
    // Every statement finds few rows by an index; the planner must not think otherwise before
    // statistics were collected, think anew each time, nor compile what runs for a tenth of a
    // millisecond.
    sql << "SET plan_cache_mode = force_generic_plan";
    for (const char* setting : {"jit", "enable_seqscan", "enable_hashjoin", "enable_mergejoin"}) {
      sql << fmt::format("SET {} = off", setting);
    }
    // Pages that a query needs and memory has not are asked for at once; 0: the server cannot.
    sql << "SELECT pg_catalog.set_config(name, '64', false) FROM pg_catalog.pg_settings WHERE name "
           "= 'effective_io_concurrency' AND setting <> '0'";
    WAYMARK_TRY(PreparePostgresSchema(sql, name, options));
    return session;
  } catch (const soci::postgresql_soci_error& error) {
    return DescribePostgres(name, error);
  } catch (const std::exception& exception) {
    return MakeError(ErrorCode::kUnavailable, "{}: cannot connect: {}", name,
                     OneLine(exception.what()));
  }
}

ConnectionState PostgresSession::state() {
  return PQstatus(native()) == CONNECTION_OK ? ConnectionState::kUsable : ConnectionState::kLost;
}

void PostgresSession::Listen() { sql_ << "LISTEN waymark_anchors"; }

void PostgresSession::AwaitAnnouncement(std::chrono::milliseconds timeout) {
  PGconn* const connection = native();
  const auto take_all = [&] {
    bool has_any = false;
    (void)PQconsumeInput(connection);
    while (PGnotify* notification = PQnotifies(connection)) {
      PQfreemem(notification);
      has_any = true;
    }
    return has_any;
  };
  // One that came with the answer to a query is here already; its socket stays silent about it.
  if (take_all() || timeout.count() <= 0) return;
  pollfd socket{.fd = PQsocket(connection), .events = POLLIN, .revents = 0};
  (void)::poll(&socket, 1, static_cast<int>(timeout.count()));
  (void)take_all();
}

}  // namespace waymark::content::internal

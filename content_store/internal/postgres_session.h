// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libpq-fe.h>
#include <soci/soci.h>

#include <chrono>
#include <exception>
#include <memory>
#include <string>

#include "content_store/anchor_store.h"
#include "content_store/internal/anchor_tables.h"
#include "mapping/base/result.h"

namespace waymark::content::internal {

/// What may be said of a database in messages: its URI without a password.
std::string PublicName(const std::string& uri);

/// What an exception of SOCI's PostgreSQL means for the store of this name.
Error DescribePostgres(const std::string& name, const std::exception& exception);

/// One PostgreSQL connection. Thread-compatible.
class PostgresSession {
 public:
  /// Connects and brings the schema to the present version if the options allow.
  /// Errors: Unavailable, NotFound, Corrupt, Unsupported.
  static Result<std::unique_ptr<PostgresSession>> Open(const std::string& uri,
                                                       const StoreOptions& options);

  soci::session& sql() { return sql_; }
  PGconn* native();
  const std::string& name() const { return name_; }
  ConnectionState state();

  /// From now on AwaitAnnouncement hears of commits.
  void Listen();
  /// Returns when something was announced, the time is over, or the connection broke.
  void AwaitAnnouncement(std::chrono::milliseconds timeout);

 private:
  PostgresSession(const std::string& uri, const std::string& name);

  const std::string name_;
  soci::session sql_;
};

}  // namespace waymark::content::internal

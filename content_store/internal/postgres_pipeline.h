// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libpq-fe.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace waymark::content::internal {

/// What one statement answered, in binary.
class PostgresRows {
 public:
  explicit PostgresRows(PGresult* result) : result_(result, &PQclear) {}

  int size() const { return PQntuples(result_.get()); }
  bool IsNull(int row, int column) const { return PQgetisnull(result_.get(), row, column) != 0; }
  /// Valid as long as these rows; empty for NULL.
  std::string_view Bytes(int row, int column) const {
    return {PQgetvalue(result_.get(), row, column),
            static_cast<std::size_t>(PQgetlength(result_.get(), row, column))};
  }
  std::string Text(int row, int column) const { return std::string(Bytes(row, column)); }
  std::int64_t Number(int row, int column) const;
  std::uint64_t Revision(int row, int column) const {
    return static_cast<std::uint64_t>(Number(row, column));
  }

 private:
  std::unique_ptr<PGresult, decltype(&PQclear)> result_;
};

/// Prepared statements of one connection that travel together: what is sent waits for no answer, so
/// several cost one round trip. After one has failed the server skips the others up to the next
/// Await, which throws soci::postgresql_soci_error for the first. Thread-compatible.
class PostgresPipeline {
 public:
  /// Borrows the connection, which others may use after Finish.
  explicit PostgresPipeline(PGconn* connection) : connection_(connection) {}

  void Prepare(const std::string& name, const std::string& text);
  /// Parameters are in binary.
  void Send(const std::string& name, const std::vector<std::string>& parameters = {});
  /// Lets the server begin; what comes of it is seen by the next Await.
  void Flush();
  /// Waits for all that was sent and returns the answers since the last Await, one a statement.
  std::vector<PostgresRows> Await();
  /// Awaits what is left and gives the connection free.
  void Finish();

 private:
  void Begin();
  [[noreturn]] void Throw(const PGresult* failed);
  void Require(int is_well);

  PGconn* const connection_;
  bool is_empty_ = true;  // nothing was sent since the last end of a group
  int groups_ = 0;        // whose answers were not read yet
};

}  // namespace waymark::content::internal

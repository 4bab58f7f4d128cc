// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_pipeline.h"

#include <soci/postgresql/soci-postgresql.h>

#include <optional>
#include <utility>

#include "content_store/internal/postgres_binary.h"

namespace waymark::content::internal {

std::int64_t PostgresRows::Number(int row, int column) const {
  return FromBinary(Bytes(row, column));
}

void PostgresPipeline::Throw(const PGresult* failed) {
  const char* const state =
      failed == nullptr ? nullptr : PQresultErrorField(failed, PG_DIAG_SQLSTATE);
  const char* const message =
      failed == nullptr ? PQerrorMessage(connection_) : PQresultErrorMessage(failed);
  throw soci::postgresql_soci_error(message, state == nullptr ? "08000" : state);
}

void PostgresPipeline::Require(int is_well) {
  if (is_well != 1) Throw(nullptr);
}

void PostgresPipeline::Begin() {
  if (PQpipelineStatus(connection_) == PQ_PIPELINE_OFF) Require(PQenterPipelineMode(connection_));
  is_empty_ = false;
}

void PostgresPipeline::Prepare(const std::string& name, const std::string& text) {
  Begin();
  Require(PQsendPrepare(connection_, name.c_str(), text.c_str(), 0, nullptr));
}

void PostgresPipeline::Send(const std::string& name, const std::vector<std::string>& parameters) {
  Begin();
  std::vector<const char*> values;
  std::vector<int> lengths;
  for (const std::string& parameter : parameters) {
    values.push_back(parameter.data());
    lengths.push_back(static_cast<int>(parameter.size()));
  }
  const std::vector<int> formats(parameters.size(), 1);
  Require(PQsendQueryPrepared(connection_, name.c_str(), static_cast<int>(parameters.size()),
                              values.data(), lengths.data(), formats.data(), 1));
}

void PostgresPipeline::Flush() {
  if (std::exchange(is_empty_, true)) return;
  Require(PQpipelineSync(connection_));
  ++groups_;
}

std::vector<PostgresRows> PostgresPipeline::Await() {
  Flush();
  std::vector<PostgresRows> answers;
  std::optional<PostgresRows> failed;
  PGresult* first_failure = nullptr;
  bool is_cut_off = false, has_ended = false;
  while (groups_ > 0) {
    PGresult* const result = PQgetResult(connection_);
    if (result == nullptr) {  // the end of one statement's answer
      // A second end says that nothing is under way, though answers are missing: the server has
      // said goodbye, and libpq has not read yet that it hung up.
      is_cut_off = std::exchange(has_ended, true) || PQstatus(connection_) != CONNECTION_OK;
      if (!is_cut_off) continue;
      (void)PQconsumeInput(connection_);
      groups_ = 0;
      break;
    }
    has_ended = false;
    PostgresRows rows(result);
    const ExecStatusType status = PQresultStatus(result);
    if (status == PGRES_PIPELINE_SYNC) {
      --groups_;
    } else if (status == PGRES_TUPLES_OK || status == PGRES_COMMAND_OK) {
      answers.push_back(std::move(rows));
    } else if (status != PGRES_PIPELINE_ABORTED && !failed) {
      first_failure = result;
      failed = std::move(rows);
    }
  }
  if (failed) Throw(first_failure);
  if (is_cut_off || PQstatus(connection_) != CONNECTION_OK) Throw(nullptr);
  return answers;
}

void PostgresPipeline::Finish() {
  if (PQpipelineStatus(connection_) == PQ_PIPELINE_OFF) return;
  (void)Await();
  Require(PQexitPipelineMode(connection_));
}

}  // namespace waymark::content::internal

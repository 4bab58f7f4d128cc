// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/store_writer.h"

namespace waymark::content::internal {

Result<void> StoreWriter::Prepare() {
  if (is_untrusted_) {
    return MakeError(ErrorCode::kUnavailable,
                     "{}: an earlier write could not be synced to disk; reopen the store to see "
                     "what the disk kept",
                     database_.name());
  }
  if (connection_ != nullptr) return {};
  WAYMARK_TRY_ASSIGN(connection_, database_.Connect());
  last_commit_ = {};
  return {};
}

std::vector<Result<WriteOutcome>> StoreWriter::Commit(
    const std::vector<const WriteRequest*>& requests) {
  has_written_ = false;
  if (requests.empty()) return {};
  if (const auto ready = Prepare(); !ready) return {requests.size(), ready.error()};
  const auto foreseen = last_commit_.Foresee(requests);
  auto outcomes = CommitOn(foreseen, requests);
  // Another server wrote, an id is taken, a limit is reached: decide on what is there.
  const bool is_not_so = !outcomes && outcomes.error().code != ErrorCode::kUnavailable;
  if (foreseen && is_not_so) outcomes = CommitOn(std::nullopt, requests);
  if (outcomes) return *std::move(outcomes);
  const ConnectionState state = connection_->state_after_failure();
  is_untrusted_ = state == ConnectionState::kUntrusted;
  if (state == ConnectionState::kLost) connection_.reset();
  return {requests.size(), outcomes.error()};
}

Result<std::vector<Result<WriteOutcome>>> StoreWriter::CommitOn(
    const std::optional<WriteBasis>& foreseen, const std::vector<const WriteRequest*>& requests) {
  WriteBatch batch(*connection_, options_.limits, rates_, options_.clock(), foreseen);
  auto outcomes = connection_->Write([&] { return batch.Run(requests); });
  if (outcomes) {
    last_commit_.Remember(batch);
    has_written_ = batch.has_written();
  } else {
    batch.ReturnRates();
  }
  return outcomes;
}

}  // namespace waymark::content::internal

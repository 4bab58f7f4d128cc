// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/last_commit.h"

#include <cstddef>

namespace waymark::content::internal {
namespace {

constexpr std::size_t kMaxOwners = 16'384;  // about 3 MB

}  // namespace

std::optional<WriteBasis> LastCommit::Foresee(
    const std::vector<const WriteRequest*>& requests) const {
  if (!is_alone_) return std::nullopt;
  WriteBasis basis{.latest = latest_, .present = {}, .usage = {}};
  for (const WriteRequest* request : requests) {
    if (request->kind != WriteKind::kCreate) return std::nullopt;
    const auto owned = usage_.find({request->record.room.text(), request->record.owner});
    if (owned == usage_.end()) return std::nullopt;
    basis.usage.insert(*owned);
  }
  return basis;
}

void LastCommit::Remember(const WriteBatch& batch) {
  is_alone_ = batch.basis_revision() == latest_;
  if (!is_alone_ || usage_.size() > kMaxOwners) usage_.clear();
  latest_ = batch.revision();
  for (const auto& [owner, owned] : batch.usage()) usage_[owner] = owned;
}

}  // namespace waymark::content::internal

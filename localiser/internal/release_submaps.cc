// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/release_submaps.h"

#include <algorithm>
#include <map>
#include <utility>

#include "localiser/internal/open_release.h"
#include "mapping/base/parallel.h"

namespace waymark::localiser::internal {

Result<ReleaseSubmaps> ReleaseSubmaps::Open(const mapping::MapDirectory& map,
                                            const mapping::Release& release,
                                            const LocaliserOptions& options,
                                            const ReleaseSubmaps* before) {
  ReleaseSubmaps submaps(map);
  submaps.options_ = options;
  submaps.released_ = release.submaps;
  if (options.memory_budget_bytes == 0) {
    WAYMARK_TRY(submaps.OpenAll(release, before));
  } else {
    WAYMARK_TRY(submaps.PrepareToOpen(release, before));
  }
  return submaps;
}

Result<void> ReleaseSubmaps::OpenAll(const mapping::Release& release,
                                     const ReleaseSubmaps* before) {
  const std::span<const OpenSubmap> shared =
      before != nullptr ? std::span<const OpenSubmap>(before->all_) : std::span<const OpenSubmap>();
  WAYMARK_TRY_ASSIGN(all_, OpenSubmaps(map_, release, shared));
  quantiser_ = IndexSubmaps(all_, before != nullptr ? before->quantiser_ : nullptr, options_);
  return {};
}

// Only what is new is read, unless cells have become too coarse.
Result<void> ReleaseSubmaps::PrepareToOpen(const mapping::Release& release,
                                           const ReleaseSubmaps* before) {
  std::map<SubmapId, std::size_t> known;
  for (std::size_t i = 0; before != nullptr && i < before->descriptors_.size(); ++i) {
    known.emplace(before->released_[i].id, before->descriptors_[i]);
  }
  mapping::Release unknown;
  for (const mapping::ReleasedSubmap& released : release.submaps) {
    WAYMARK_TRY(OpenSubmap::CheckPlace(released));
    if (known.count(released.id) == 0) unknown.submaps.push_back(released);
  }
  WAYMARK_TRY_ASSIGN(std::vector<OpenSubmap> opened, OpenSubmaps(map_, unknown, {}));
  for (const OpenSubmap& submap : opened) {
    known.emplace(submap.released().id, submap.descriptors().size());
  }
  std::size_t largest = 0;
  for (const mapping::ReleasedSubmap& released : release.submaps) {
    descriptors_.push_back(known.at(released.id));
    largest = std::max(largest, descriptors_.back());
  }
  if (before != nullptr && before->resident_ != nullptr &&
      IsFineEnough(*before->quantiser_, largest)) {
    quantiser_ = before->quantiser_;
    resident_ = before->resident_;
    return {};
  }
  if (opened.size() < release.submaps.size()) {
    WAYMARK_TRY_ASSIGN(opened, OpenSubmaps(map_, release, opened));
  }
  quantiser_ = TrainQuantiser(opened, options_);
  resident_ = std::make_shared<ResidentSubmaps>(options_.memory_budget_bytes);
  return {};
}

Result<OpenSubmap> ReleaseSubmaps::Get(std::size_t i) const {
  const mapping::ReleasedSubmap& released = released_[i];
  WAYMARK_TRY_ASSIGN(const OpenSubmap submap,
                     resident_->Get(released.id, [&]() -> Result<OpenSubmap> {
                       WAYMARK_TRY_ASSIGN(OpenSubmap opened,
                                          OpenSubmap::Open(map_.SubmapPath(released.id), released));
                       opened.Index(*quantiser_, options_);
                       return opened;
                     }));
  return submap.PlacedBy(released);
}

TakenSubmaps ReleaseSubmaps::Take(std::span<const std::size_t> indices) const {
  TakenSubmaps taken;
  if (resident_ == nullptr) {
    for (const std::size_t i : indices) taken.submaps.push_back(all_[i]);
    return taken;
  }
  std::vector<std::size_t> missing;  // positions in `indices`
  for (std::size_t k = 0; k < indices.size(); ++k) {
    if (!resident_->Holds(released_[indices[k]].id)) missing.push_back(k);
  }
  std::vector<std::optional<Result<OpenSubmap>>> outcomes(indices.size());
  ParallelFor(missing.size(), {},
              [&](std::size_t m) { outcomes[missing[m]] = Get(indices[missing[m]]); });
  for (std::size_t k = 0; k < indices.size(); ++k) {
    Result<OpenSubmap> outcome = outcomes[k] ? *std::move(outcomes[k]) : Get(indices[k]);
    if (outcome) {
      taken.submaps.push_back(*std::move(outcome));
    } else if (++taken.failures == 1) {
      taken.failure = ToString(outcome.error());
    }
  }
  return taken;
}

LocaliserMemory ReleaseSubmaps::memory() const {
  if (resident_ != nullptr) return resident_->memory();
  LocaliserMemory memory{.resident_submaps = all_.size()};
  for (const OpenSubmap& submap : all_) memory.resident_bytes += submap.bytes();
  memory.peak_bytes = memory.resident_bytes;
  return memory;
}

}  // namespace waymark::localiser::internal

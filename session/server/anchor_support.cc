// SPDX-License-Identifier: Apache-2.0
#include "session/server/anchor_support.h"

#include <algorithm>
#include <utility>

namespace waymark::session {

ReleaseHistory::ReleaseHistory(std::shared_ptr<const LiveRelease> live,
                               std::shared_ptr<const LiveRelease> before, LoadRelease load)
    : live_(std::move(live)), before_(std::move(before)), load_(std::move(load)) {}

std::shared_ptr<const LiveRelease> ReleaseHistory::FindParent(const LiveRelease& of) const {
  const auto parent = of.release.parent_epoch;
  if (!parent || *parent >= of.release.epoch) return nullptr;
  if (before_ && before_->release.epoch == *parent) return before_;
  if (!load_) return nullptr;
  auto release = load_(*parent);
  if (!release || release->epoch != *parent) return nullptr;
  return std::make_shared<const LiveRelease>(*std::move(release));
}

std::vector<std::shared_ptr<const LiveRelease>> ReleaseHistory::Since(std::uint64_t epoch) {
  const std::uint64_t first = before_ ? std::min(epoch, before_->release.epoch) : epoch;
  const auto oldest = [&] { return ancestors_.empty() ? live_ : ancestors_.back(); };
  while (!has_all_ && oldest()->release.epoch > first) {
    auto parent = FindParent(*oldest());
    has_all_ = parent == nullptr;
    if (parent) ancestors_.push_back(std::move(parent));
  }
  std::vector<std::shared_ptr<const LiveRelease>> since;
  for (const auto& ancestor : ancestors_) {
    if (ancestor->release.epoch >= first) since.push_back(ancestor);
  }
  std::ranges::reverse(since);
  const bool went_back = before_ && std::ranges::find(since, before_) == since.end();
  if (went_back) since.push_back(before_);
  return since;
}

std::optional<content::AnchorRecord> RenewSupport(const content::AnchorRecord& record,
                                                  ReleaseHistory& history,
                                                  const TangentPlane& map_plane) {
  const LiveRelease& live = history.live();
  const std::size_t live_count = CountLive(record, live);
  const bool is_marked = record.unsupported_since_epoch.has_value();
  if (record.attachments.empty() || (live_count == kMaxAttachments && !is_marked)) return {};
  content::AnchorRecord next = record;
  if (live_count == 0 && !is_marked) {
    for (const auto& between : history.Since(record.epoch)) next = HoldIn(*between, next);
  }
  next = HoldIn(live, next);
  const std::size_t next_count = CountLive(next, live);
  if (next_count == live_count && is_marked == (next_count == 0)) return {};
  next.epoch = live.release.epoch;
  next.unsupported_since_epoch.reset();
  if (next_count == 0) next.unsupported_since_epoch = next.epoch;
  next.place = map_plane.ToGeo(Point<Map>(next.map_from_anchor.translation()));
  return next;
}

}  // namespace waymark::session

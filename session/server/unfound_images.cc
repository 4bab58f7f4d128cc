// SPDX-License-Identifier: Apache-2.0
#include "session/server/unfound_images.h"

#include <algorithm>

namespace waymark::session {
namespace {

std::size_t BytesOf(const localiser::LocalisationRequest& request) {
  const auto& features = std::get<mapping::ImageFeatures>(request.image);
  return sizeof(request) +
         features.keypoints.size() * (sizeof(mapping::Keypoint) + sizeof(mapping::Descriptor));
}

}  // namespace

Result<void> UnfoundImagesOptions::Validate() const {
  if (max_age.count() > 0) return {};
  return MakeError(ErrorCode::kInvalidArgument, "unfound images: expected max_age > 0, found {} s",
                   max_age.count());
}

std::vector<UnfoundImages::Named> UnfoundImages::Find(const LocaliseQuery& query, Instant now) {
  const std::lock_guard lock(mutex_);
  DropOld(now);
  std::vector<Named> found;
  for (const EarlierImage& earlier : query.earlier) {
    const auto entry = by_phone_.find({query.ticket, earlier.request});
    if (entry == by_phone_.end()) continue;
    found.push_back({entry->second->request, earlier.vo_from_camera});
  }
  const auto is_named = [&](RequestNumber request) {
    return std::ranges::any_of(
        query.earlier, [&](const EarlierImage& earlier) { return earlier.request == request; });
  };
  for (auto entry = by_phone_.lower_bound({query.ticket, RequestNumber{0}});
       entry != by_phone_.end() && entry->first.first == query.ticket;) {
    const auto next = std::next(entry);
    if (!is_named(entry->first.second)) Drop(entry);
    entry = next;
  }
  return found;
}

void UnfoundImages::Keep(const LocaliseQuery& query, Request request, Instant now) {
  const std::size_t bytes = BytesOf(*request);
  const Key key{query.ticket, query.request};
  const std::lock_guard lock(mutex_);
  DropOld(now);
  if (const auto before = by_phone_.find(key); before != by_phone_.end()) Drop(before);
  images_.push_back({key, std::move(request), bytes, now});
  by_phone_.emplace(key, std::prev(images_.end()));
  bytes_ += bytes;
  while (bytes_ > options_.max_bytes) Drop(by_phone_.find(images_.front().key));
}

void UnfoundImages::Forget(Ticket phone) {
  const std::lock_guard lock(mutex_);
  auto entry = by_phone_.lower_bound({phone, RequestNumber{0}});
  while (entry != by_phone_.end() && entry->first.first == phone) Drop(entry++);
}

std::size_t UnfoundImages::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

void UnfoundImages::Drop(std::map<Key, Images::iterator>::iterator entry) {
  bytes_ -= entry->second->bytes;
  images_.erase(entry->second);
  by_phone_.erase(entry);
}

void UnfoundImages::DropOld(Instant now) {
  while (!images_.empty() && now - images_.front().since > options_.max_age) {
    Drop(by_phone_.find(images_.front().key));
  }
}

}  // namespace waymark::session

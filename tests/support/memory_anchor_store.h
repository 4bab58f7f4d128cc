// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>

#include "content_store/anchor_rules.h"
#include "content_store/anchor_store.h"
#include "content_store/internal/query_match.h"

namespace waymark::support {

/// Anchors in memory, for tests of those who use a store: the same answers, no disk. Thread-safe.
class MemoryAnchorStore : public content::AnchorStore {
 public:
  Result<content::WriteOutcome> Create(const content::AnchorRecord& record) override {
    WAYMARK_TRY(content::Validate(record));
    const std::lock_guard lock(mutex_);
    const auto [entry, is_new] = entries_.try_emplace({record.room, record.id});
    std::string creation = content::ContentFingerprint(record);
    if (is_new) {
      entry->second.creation = std::move(creation);
      return Write(entry->second, record);
    }
    if (entry->second.present && entry->second.creation == creation)
      return {*entry->second.present};
    return {content::WriteConflict{entry->second.present}};
  }

  Result<content::WriteOutcome> Update(const content::AnchorRecord& record,
                                       std::uint64_t expected_revision) override {
    WAYMARK_TRY(content::Validate(record));
    const std::lock_guard lock(mutex_);
    Entry* entry = FindExpected(record.room, record.id, expected_revision);
    if (entry == nullptr) return {content::WriteConflict{Present(record.room, record.id)}};
    content::AnchorRecord next = record;
    next.owner = entry->present->owner;
    next.created_utc_ms = entry->present->created_utc_ms;
    return Write(*entry, std::move(next));
  }

  Result<content::WriteOutcome> Move(const content::AnchorMove& move,
                                     std::uint64_t expected_revision) override {
    WAYMARK_TRY_ASSIGN(auto record, Find(move.room, move.id));
    if (!record) return {content::WriteConflict{}};
    record->map_from_anchor = move.map_from_anchor;
    record->epoch = move.epoch;
    record->attachments = move.attachments;
    record->place = move.place;
    record->changed_utc_ms = move.changed_utc_ms;
    record->unsupported_since_epoch.reset();
    return Update(*record, expected_revision);
  }

  std::vector<Result<content::WriteOutcome>> CreateMany(
      std::span<const content::AnchorRecord> records) override {
    std::vector<Result<content::WriteOutcome>> outcomes;
    for (const content::AnchorRecord& record : records) outcomes.push_back(Create(record));
    return outcomes;
  }

  std::vector<Result<content::WriteOutcome>> UpdateMany(
      std::span<const content::AnchorRecord> records) override {
    std::vector<Result<content::WriteOutcome>> outcomes;
    for (const auto& record : records) outcomes.push_back(Update(record, record.revision));
    return outcomes;
  }

  Result<std::size_t> Expire(std::int64_t now_utc_ms, std::size_t limit) override {
    std::vector<content::AnchorRecord> due;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [key, entry] : entries_) {
        if (due.size() < limit && entry.present && entry.present->expires_utc_ms &&
            *entry.present->expires_utc_ms <= now_utc_ms) {
          due.push_back(*entry.present);
        }
      }
    }
    for (const auto& record : due) (void)Delete(record.room, record.id, record.revision);
    return due.size();
  }

  /// The states of the log as of the first page, in order of their revisions.
  Result<content::AnchorPage> Query(const content::AnchorQuery& query) override {
    WAYMARK_TRY(query.Validate());
    const std::lock_guard lock(mutex_);
    const std::uint64_t as_of = query.after ? query.after->as_of : log_.size();
    std::map<std::pair<RoomId, AnchorId>, const content::AnchorRecord*> then;
    for (std::uint64_t i = 0; i < as_of; ++i) {
      then[{log_[i].room, log_[i].id}] = log_[i].record ? &*log_[i].record : nullptr;
    }
    std::map<std::uint64_t, const content::AnchorRecord*> matches;
    for (const auto& [key, record] : then) {
      const bool is_later = record && (!query.after || record->revision > query.after->revision);
      if (is_later && content::internal::Matches(query, *record)) {
        matches.emplace(record->revision, record);
      }
    }
    content::AnchorPage page{.revision = as_of, .anchors = {}, .next = std::nullopt};
    for (const auto& [revision, record] : matches) {
      if (page.anchors.size() == query.limit) {
        page.next = {as_of, 0, page.anchors.back().revision};
        break;
      }
      page.anchors.push_back(*record);
    }
    return page;
  }

  Result<content::WriteOutcome> Delete(const RoomId& room, const AnchorId& id,
                                       std::uint64_t expected_revision) override {
    const std::lock_guard lock(mutex_);
    Entry* entry = FindExpected(room, id, expected_revision);
    if (entry == nullptr) return {content::WriteConflict{Present(room, id)}};
    content::AnchorRecord last = *std::exchange(entry->present, std::nullopt);
    last.revision = log_.size() + 1;
    entry->revision = last.revision;
    log_.push_back({last.revision, id, room, std::nullopt});
    changed_.notify_all();
    return {std::move(last)};
  }

  Result<std::optional<content::AnchorRecord>> Find(const RoomId& room,
                                                    const AnchorId& id) override {
    const std::lock_guard lock(mutex_);
    return Present(room, id);
  }

  Result<content::RoomSnapshot> LoadRoom(const RoomId& room) override {
    const std::lock_guard lock(mutex_);
    content::RoomSnapshot snapshot{log_.size(), {}};
    for (const auto& [key, entry] : entries_) {
      if (key.first == room && entry.present) snapshot.anchors.push_back(*entry.present);
    }
    return snapshot;
  }

  Result<std::vector<content::RoomSummary>> ListRooms() override {
    const std::lock_guard lock(mutex_);
    std::vector<content::RoomSummary> rooms;
    for (const auto& [key, entry] : entries_) {
      if (rooms.empty() || rooms.back().room != key.first) rooms.push_back({key.first, 0, 0});
      rooms.back().anchors += entry.present ? 1 : 0;
      rooms.back().revision = std::max(rooms.back().revision, entry.revision);
    }
    return rooms;
  }

  Result<std::vector<content::AnchorRecord>> FindNear(const RoomId& room, const GeoPoint& centre,
                                                      double radius_m, std::size_t limit) override {
    WAYMARK_TRY(centre.Validate());
    if (!std::isfinite(radius_m) || radius_m < 0) {
      return MakeError(ErrorCode::kInvalidArgument, "radius: expected at least 0 m, found {}",
                       radius_m);
    }
    const std::lock_guard lock(mutex_);
    std::vector<std::pair<double, content::AnchorRecord>> near;
    for (const auto& [key, entry] : entries_) {
      if (key.first != room || !entry.present) continue;
      const double distance_m = GeodesicDistance(centre, entry.present->place);
      if (distance_m <= radius_m) near.emplace_back(distance_m, *entry.present);
    }
    std::sort(near.begin(), near.end(), [](const auto& a, const auto& b) {
      return std::tie(a.first, a.second.id) < std::tie(b.first, b.second.id);
    });
    std::vector<content::AnchorRecord> records;
    for (auto& [distance_m, record] : near) {
      if (records.size() < limit) records.push_back(std::move(record));
    }
    return records;
  }

  Result<std::vector<content::AnchorChange>> LoadChanges(std::uint64_t after_revision,
                                                         std::size_t limit) override {
    const std::lock_guard lock(mutex_);
    std::vector<content::AnchorChange> changes;
    for (std::uint64_t i = after_revision; i < log_.size() && changes.size() < limit; ++i) {
      changes.push_back(log_[i]);
    }
    return changes;
  }

  Result<std::vector<content::AnchorChange>> LoadRoomChanges(const RoomId& room,
                                                             std::uint64_t after_revision,
                                                             std::size_t limit) override {
    const std::lock_guard lock(mutex_);
    std::vector<content::AnchorChange> changes;
    for (std::uint64_t i = after_revision; i < log_.size() && changes.size() < limit; ++i) {
      if (log_[i].room == room) changes.push_back(log_[i]);
    }
    return changes;
  }

  Result<std::uint64_t> WaitForChanges(std::uint64_t after_revision,
                                       std::chrono::milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, timeout, [&] { return log_.size() > after_revision; });
    return log_.size();
  }

 private:
  struct Entry {
    std::optional<content::AnchorRecord> present;  // absent: deleted
    std::string creation;
    std::uint64_t revision = 0;
  };

  content::WriteOutcome Write(Entry& entry, content::AnchorRecord record) {
    record.revision = log_.size() + 1;
    entry.revision = record.revision;
    entry.present = record;
    log_.push_back({record.revision, record.id, record.room, record});
    changed_.notify_all();
    return record;
  }
  std::optional<content::AnchorRecord> Present(const RoomId& room, const AnchorId& id) {
    const auto entry = entries_.find({room, id});
    if (entry == entries_.end()) return std::nullopt;
    return entry->second.present;
  }
  Entry* FindExpected(const RoomId& room, const AnchorId& id, std::uint64_t expected_revision) {
    const auto entry = entries_.find({room, id});
    if (entry == entries_.end() || !entry->second.present) return nullptr;
    return entry->second.revision == expected_revision ? &entry->second : nullptr;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::pair<RoomId, AnchorId>, Entry> entries_;  // guarded by mutex_
  std::vector<content::AnchorChange> log_;                // guarded by mutex_; revision = index + 1
};

}  // namespace waymark::support

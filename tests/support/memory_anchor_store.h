// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>

#include "content_store/anchor_rules.h"
#include "content_store/anchor_store.h"

namespace waymark::support {

/// Anchors in memory, for tests of those who use a store: the same answers, no disk. Thread-safe.
class MemoryAnchorStore final : public content::AnchorStore {
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

  Result<content::WriteOutcome> Delete(const RoomId& room, const AnchorId& id,
                                       std::uint64_t expected_revision) override {
    const std::lock_guard lock(mutex_);
    Entry* entry = FindExpected(room, id, expected_revision);
    if (entry == nullptr) return {content::WriteConflict{Present(room, id)}};
    content::AnchorRecord last = *std::exchange(entry->present, std::nullopt);
    last.revision = log_.size() + 1;
    entry->revision = last.revision;
    log_.push_back({last.revision, id, room, std::nullopt});
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
  std::map<std::pair<RoomId, AnchorId>, Entry> entries_;  // guarded by mutex_
  std::vector<content::AnchorChange> log_;                // guarded by mutex_; revision = index + 1
};

}  // namespace waymark::support

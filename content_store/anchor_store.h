// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "content_store/anchor_record.h"
#include "mapping/base/result.h"

namespace waymark::content {

/// The answer to a write that lost a race: what stands there now (absent: it was deleted).
struct WriteConflict {
  std::optional<AnchorRecord> current;
};

/// The stored state after a write, or why it did not apply.
using WriteOutcome = std::variant<AnchorRecord, WriteConflict>;

/// A consistent picture of one room.
struct RoomSnapshot {
  std::uint64_t revision = 0;         ///< every change up to here is in, none after
  std::vector<AnchorRecord> anchors;  ///< sorted by id
};

/// Durable anchors. A write is acknowledged only when it would survive a power cut. Thread-safe.
/// Every operation may fail with Unavailable (disk, database) or Corrupt.
class AnchorStore {
 public:
  virtual ~AnchorStore() = default;

  /// Creates an anchor. The same id with the same content again is the earlier success (a retry);
  /// with other content a conflict. Errors: InvalidArgument for values beyond their limits.
  virtual Result<WriteOutcome> Create(const AnchorRecord& record) = 0;
  /// Replaces pose, attachments, epoch, kind and payload if the revision is still the expected one.
  virtual Result<WriteOutcome> Update(const AnchorRecord& record,
                                      std::uint64_t expected_revision) = 0;
  /// Deletes if the revision is the expected one; deleting what is gone is a conflict with nothing.
  virtual Result<WriteOutcome> Delete(const RoomId& room, const AnchorId& id,
                                      std::uint64_t expected_revision) = 0;

  virtual Result<std::optional<AnchorRecord>> Find(const RoomId& room, const AnchorId& id) = 0;
  virtual Result<RoomSnapshot> LoadRoom(const RoomId& room) = 0;
  /// Anchors of a room within a ground distance, nearest first.
  virtual Result<std::vector<AnchorRecord>> FindNear(const RoomId& room, const GeoPoint& centre,
                                                     double radius_m, std::size_t limit) = 0;
  /// Changes after a revision, oldest first, at most `limit`.
  virtual Result<std::vector<AnchorChange>> LoadChanges(std::uint64_t after_revision,
                                                        std::size_t limit) = 0;
};

/// Opens or creates a one-file SQLite store (WAL, synchronous=FULL).
/// Errors: Unavailable (cannot open), Corrupt (damaged), Unsupported (newer schema).
Result<std::unique_ptr<AnchorStore>> OpenSqliteStore(const std::filesystem::path& file);

}  // namespace waymark::content

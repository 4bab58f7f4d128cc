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

/// One line of a store's table of contents.
struct RoomSummary {
  RoomId room;
  std::size_t anchors = 0;
  std::uint64_t revision = 0;  ///< of the room's latest change
};

/// Durable anchors. A write is acknowledged only when it would survive a power cut. Thread-safe.
/// Every operation may fail with Unavailable (disk, database) or Corrupt. After Unavailable a write
/// may or may not have happened: repeat it, the expected revision and the id keep it single.
class AnchorStore {
 public:
  virtual ~AnchorStore() = default;

  /// Creates an anchor. The same id with the same content again (see ContentFingerprint) is the
  /// earlier success, answered with the present record: a retry. With other content it is a
  /// conflict; so is the id of a deleted anchor, which is never used again.
  /// Errors: InvalidArgument for values beyond their limits (see Validate in anchor_rules.h).
  virtual Result<WriteOutcome> Create(const AnchorRecord& record) = 0;
  /// Replaces pose, place, epoch, attachments, kind, payload and time of change if the revision is
  /// still the expected one. Owner and time of creation stay.
  virtual Result<WriteOutcome> Update(const AnchorRecord& record,
                                      std::uint64_t expected_revision) = 0;
  /// Deletes if the revision is the expected one; deleting what is gone is a conflict with nothing.
  /// Answers with the record as it last stood, carrying the revision of its deletion.
  virtual Result<WriteOutcome> Delete(const RoomId& room, const AnchorId& id,
                                      std::uint64_t expected_revision) = 0;

  virtual Result<std::optional<AnchorRecord>> Find(const RoomId& room, const AnchorId& id) = 0;
  virtual Result<RoomSnapshot> LoadRoom(const RoomId& room) = 0;
  /// Rooms that ever held an anchor, sorted by name.
  virtual Result<std::vector<RoomSummary>> ListRooms() = 0;
  /// The `limit` nearest anchors of a room within a ground distance (heights ignored), nearest
  /// first, equally near ones by id. Errors: InvalidArgument (centre, radius not finite or < 0).
  virtual Result<std::vector<AnchorRecord>> FindNear(const RoomId& room, const GeoPoint& centre,
                                                     double radius_m, std::size_t limit) = 0;
  /// Changes after a revision, oldest first, at most `limit`. Revisions follow each other without a
  /// gap, so a reader that asks again from the last one it saw misses nothing.
  virtual Result<std::vector<AnchorChange>> LoadChanges(std::uint64_t after_revision,
                                                        std::size_t limit) = 0;
};

enum class OpenMode { kCreateIfAbsent, kExisting };

struct SqliteStoreOptions {
  OpenMode mode = OpenMode::kCreateIfAbsent;
  int busy_timeout_s = 5;  ///< [0, 3600]; wait for another process's write before Unavailable

  Result<void> Validate() const;
};

/// Opens or creates a one-file SQLite store (WAL, synchronous=FULL). Several processes may open the
/// same file: their writes take turns, and each sees what the others committed.
/// Errors: NotFound (kExisting), Unavailable (cannot open), Corrupt (damaged, or not a store),
/// Unsupported (schema of a newer program).
Result<std::unique_ptr<AnchorStore>> OpenSqliteStore(const std::filesystem::path& file,
                                                     const SqliteStoreOptions& options = {});

}  // namespace waymark::content

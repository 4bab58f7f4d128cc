// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "content_store/anchor_query.h"
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
  /// Errors: InvalidArgument for values beyond their limits (see Validate in anchor_rules.h) and
  /// for an owner who holds as much as StoreLimits allow.
  virtual Result<WriteOutcome> Create(const AnchorRecord& record) = 0;
  /// Creates many, each with its own outcome, in few transactions: for imports. Owners' rates do
  /// not count here.
  virtual std::vector<Result<WriteOutcome>> CreateMany(std::span<const AnchorRecord> records) = 0;
  /// Replaces everything but owner and time of creation if the revision is still the expected one.
  virtual Result<WriteOutcome> Update(const AnchorRecord& record,
                                      std::uint64_t expected_revision) = 0;
  /// Updates many, each if its revision is still the one that its record carries, in few
  /// transactions. Owners' rates do not count here.
  virtual std::vector<Result<WriteOutcome>> UpdateMany(std::span<const AnchorRecord> records) = 0;
  /// Gives an anchor another place if the revision is still the expected one.
  virtual Result<WriteOutcome> Move(const AnchorMove& move, std::uint64_t expected_revision) = 0;
  /// Deletes if the revision is the expected one; deleting what is gone is a conflict with nothing.
  /// Answers with the record as it last stood, carrying the revision of its deletion.
  virtual Result<WriteOutcome> Delete(const RoomId& room, const AnchorId& id,
                                      std::uint64_t expected_revision) = 0;
  /// Deletes anchors whose time of expiry has come, at most `limit` of them, and says how many.
  virtual Result<std::size_t> Expire(std::int64_t now_utc_ms, std::size_t limit) = 0;

  virtual Result<std::optional<AnchorRecord>> Find(const RoomId& room, const AnchorId& id) = 0;
  virtual Result<RoomSnapshot> LoadRoom(const RoomId& room) = 0;
  /// Rooms that ever held an anchor, sorted by name.
  virtual Result<std::vector<RoomSummary>> ListRooms() = 0;
  /// One page of an answer. Errors: InvalidArgument; Conflict when too much was written since the
  /// first page (100,000 changes, or a compaction): begin again.
  virtual Result<AnchorPage> Query(const AnchorQuery& query) = 0;
  /// The `limit` nearest anchors of a room within a ground distance (heights ignored), nearest
  /// first, equally near ones by id. Errors: InvalidArgument (centre, radius not finite or < 0).
  virtual Result<std::vector<AnchorRecord>> FindNear(const RoomId& room, const GeoPoint& centre,
                                                     double radius_m, std::size_t limit) = 0;

  /// Changes after a revision, oldest first, at most `limit`. A reader that asks again from the
  /// last one it saw, beginning with the revision of a snapshot, meets every change once. Where the
  /// store was compacted, of each anchor only the latest change is left.
  virtual Result<std::vector<AnchorChange>> LoadChanges(std::uint64_t after_revision,
                                                        std::size_t limit) = 0;
  /// The same of one room.
  virtual Result<std::vector<AnchorChange>> LoadRoomChanges(const RoomId& room,
                                                            std::uint64_t after_revision,
                                                            std::size_t limit) = 0;
  /// Waits until there is a change after the revision, whoever wrote it, or the time is over, and
  /// returns the latest revision.
  virtual Result<std::uint64_t> WaitForChanges(std::uint64_t after_revision,
                                               std::chrono::milliseconds timeout) = 0;
};

enum class OpenMode { kCreateIfAbsent, kExisting };
/// What becomes of a store that an earlier version of this program wrote.
enum class Migration { kAutomatic, kRefuse };

/// What one owner may have in one room, and how fast.
struct StoreLimits {
  std::size_t max_anchors_per_owner = 100'000;
  std::size_t max_payload_bytes_per_owner = std::size_t{1} << 30;
  /// Single writes to anchors of one owner, in all rooms, through this process. 0: no limit.
  double max_writes_per_second = 500;
  double max_burst = 1000;  ///< writes that may come at once after a pause; at least 1

  Result<void> Validate() const;
  static StoreLimits None();  ///< for tools and imports
};

struct StoreOptions {
  OpenMode mode = OpenMode::kCreateIfAbsent;
  int busy_timeout_s = 5;  ///< [0, 3600]; wait for another process's write before Unavailable
  Migration migration = Migration::kAutomatic;
  /// SQLite: pages of 4 KiB in the write-ahead log after which they move to the main file,
  /// [100, 1'000'000]. More spare writes, fewer spare disk and time to open after a crash.
  int checkpoint_pages = 16000;
  StoreLimits limits{};
  /// The clock of the writes per second; tests set their own.
  std::function<std::chrono::steady_clock::time_point()> clock = std::chrono::steady_clock::now;

  Result<void> Validate() const;
};
using SqliteStoreOptions = StoreOptions;

/// Opens or creates a one-file SQLite store (WAL, synchronous=FULL). Several processes may open the
/// same file: their writes take turns, and each sees what the others committed.
/// Errors: NotFound (kExisting), Unavailable (cannot open), Corrupt (damaged, or not a store),
/// Unsupported (schema of a newer program, or of an older one under Migration::kRefuse).
Result<std::unique_ptr<AnchorStore>> OpenSqliteStore(const std::filesystem::path& file,
                                                     const StoreOptions& options = {});

/// Opens the store in a PostgreSQL database, or creates it there, in a schema "waymark" of its own.
/// Any number of servers may share it. A lost connection is an Unavailable answer and is opened
/// again with the next operation. Errors: as above. Messages never show the URI's password.
Result<std::unique_ptr<AnchorStore>> OpenPostgresStore(const std::string& uri,
                                                       const StoreOptions& options = {});

/// A location that starts with postgresql:// or postgres:// is a database, any other one a file.
bool IsPostgresLocation(const std::string& location);
Result<std::unique_ptr<AnchorStore>> OpenStore(const std::string& location,
                                               const StoreOptions& options = {});

}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <exception>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "content_store/anchor_store.h"
#include "content_store/internal/cell_index.h"
#include "content_store/internal/record_codec.h"

namespace waymark::content::internal {

struct AnchorKey {
  RoomId room;
  AnchorId id;
  friend auto operator<=>(const AnchorKey&, const AnchorKey&) = default;
};

/// A row of the log as the database gave it; see VerifyRow.
struct LogRow {
  std::uint64_t revision = 0;
  std::uint64_t previous = 0;  ///< revision of the anchor's state before this one, 0: none
  std::string room, id, state;
  std::int64_t checksum = 0;
};

/// A row of the index as the database gave it.
struct PlaceRow {
  AnchorKey key;
  std::uint64_t revision = 0;
  std::optional<std::int64_t> cell{}, changed{}, expires{};  ///< absent: deleted, or never
  bool is_public = false;
};

/// Where a live anchor is in an order: its cell or its time of change, then its revision.
struct Position {
  std::int64_t key = std::numeric_limits<std::int64_t>::min();
  std::uint64_t revision = 0;
  friend auto operator<=>(const Position&, const Position&) = default;
};

enum class ScanOrder { kCell, kChanged };

struct Scan {
  ScanOrder order = ScanOrder::kCell;
  std::optional<RoomId> room{};  ///< absent: public anchors of all rooms, by cell
  CellRanges ranges{};           ///< of keys, ascending, both ends included
  std::uint64_t newest = 0;      ///< anchors changed after this revision are left out
  Position after{};
  std::size_t limit = 0;
};

struct OwnerKey {
  std::string room, owner;
  friend auto operator<=>(const OwnerKey&, const OwnerKey&) = default;
};
struct Usage {
  std::int64_t anchors = 0;
  std::int64_t bytes = 0;  ///< of payloads
};

/// What writes are decided on.
struct WriteBasis {
  std::uint64_t latest = 0;  ///< the store's revision
  std::vector<LogRow> present;
  std::map<OwnerKey, Usage> usage;
};

/// Below `through` the log holds `rows` rows, of superseded states none.
struct Compaction {
  std::uint64_t through = 0;
  std::uint64_t rows = 0;
};

enum class ConnectionState {
  kUsable,
  kLost,       ///< open another one
  kUntrusted,  ///< a sync to disk failed: what the disk holds is not known
};

/// The store's tables as one connection sees them; FORMAT.md describes them. All functions may
/// throw what SOCI throws, so call them inside Guard or Read. Thread-compatible.
class AnchorTables {
 public:
  virtual ~AnchorTables() = default;

  /// The store's name for messages.
  virtual const std::string& name() const = 0;
  virtual Error Describe(const std::exception& exception) const = 0;
  virtual ConnectionState state() = 0;

  virtual void BeginRead() = 0;   ///< one picture until Commit or Rollback
  virtual void BeginWrite() = 0;  ///< the only writer until then
  virtual void Commit() = 0;
  virtual void Rollback() = 0;

  virtual std::uint64_t LatestRevision() = 0;
  virtual Compaction LoadCompaction() = 0;
  /// The latest states of those keys that ever were, in any order, under the keys asked for. What
  /// the index points to but the log has not comes without a state.
  virtual std::vector<LogRow> FindLatest(const std::vector<AnchorKey>& keys) = 0;
  /// The states of those revisions that are there, in any order.
  virtual std::vector<LogRow> LoadStates(const std::vector<std::uint64_t>& revisions) = 0;
  /// Live anchors in order of their position, the first `limit`.
  virtual std::vector<Position> FindPlaces(const Scan& scan) = 0;
  /// Live anchors of a room by id, after an id: revisions.
  virtual std::vector<std::uint64_t> ListRoom(const RoomId& room) = 0;
  /// States that were the latest at the revision `since` and are not any more.
  virtual std::vector<std::uint64_t> FindReplaced(const std::optional<RoomId>& room,
                                                  std::uint64_t since, std::size_t limit) = 0;
  virtual std::vector<LogRow> LoadLog(const std::optional<RoomId>& room, std::uint64_t after,
                                      std::size_t limit) = 0;
  virtual std::vector<RoomSummary> ListRooms() = 0;
  /// Live anchors whose expiry is not after `now`.
  virtual std::vector<PlaceRow> FindExpired(std::int64_t now_utc_ms, std::size_t limit) = 0;
  /// The index by room and id, after a key; for checks.
  virtual std::vector<PlaceRow> ListPlaces(const std::optional<AnchorKey>& after,
                                           std::size_t limit) = 0;
  virtual std::map<OwnerKey, Usage> FindUsage(const std::vector<OwnerKey>& owners) = 0;
  /// LatestRevision, FindLatest and FindUsage at once.
  virtual WriteBasis LoadBasis(const std::vector<AnchorKey>& keys,
                               const std::vector<OwnerKey>& owners) = 0;
  virtual std::map<OwnerKey, Usage> ListUsage() = 0;
  /// States with revisions in (after, through].
  virtual std::uint64_t CountLog(std::uint64_t after, std::uint64_t through) = 0;

  /// False unless this transaction began at this revision of the store. Or true, and the commit
  /// fails with Conflict, where an answer has a way to go.
  virtual bool Require(std::uint64_t latest) = 0;

  // What these do may fail as late as in Commit.
  /// Adds states to the log; `previous` goes with each.
  virtual void AppendLog(const std::vector<LogRow>& rows) = 0;
  /// Adds rows to the index. Fails with Corrupt if it has one of these keys.
  virtual void AddPlaces(const std::vector<PlaceRow>& places) = 0;
  /// Replaces rows of the index, which has all these keys; every key once.
  virtual void ChangePlaces(const std::vector<PlaceRow>& places) = 0;
  virtual void PutUsage(const std::map<OwnerKey, Usage>& usage) = 0;
  /// Tells other servers, when committed.
  virtual void Announce(std::uint64_t revision) = 0;
  /// Removes superseded states with revisions in (after, through].
  virtual void RemoveSuperseded(std::uint64_t after, std::uint64_t through) = 0;
  virtual void StoreCompaction(const Compaction& compaction) = 0;
  /// Gives room back to the disk; outside a transaction.
  virtual void Vacuum() = 0;
  /// What the database itself finds wrong with its structure.
  virtual std::vector<std::string> CheckStructure() = 0;

  /// Waits for an Announce of anybody; returns early at will. False: this database has none.
  virtual bool AwaitAnnouncement(std::chrono::milliseconds timeout) = 0;

  /// Runs `action`, which returns a Result and may throw what SOCI throws.
  template <typename Action>
  std::invoke_result_t<Action> Guard(Action&& action) {
    try {
      return std::forward<Action>(action)();
    } catch (const std::exception& exception) {
      return Describe(exception);
    }
  }

  /// Runs `action` on one consistent picture of the database.
  template <typename Action>
  std::invoke_result_t<Action> Read(Action&& action) {
    return Guard([&]() -> std::invoke_result_t<Action> {
      BeginRead();
      try {
        auto result = action();
        Commit();
        return result;
      } catch (...) {
        RollbackQuietly();
        throw;
      }
    });
  }

  /// Runs `action` as the only writer; commits if it returns a value.
  template <typename Action>
  std::invoke_result_t<Action> Write(Action&& action) {
    return Guard([&]() -> std::invoke_result_t<Action> {
      try {
        BeginWrite();
        auto result = action();
        if (result) {
          Commit();
        } else {
          Rollback();
        }
        return result;
      } catch (...) {
        state_after_failure_ = state();
        RollbackQuietly();
        throw;
      }
    });
  }
  /// The state right after the last failed Write.
  ConnectionState state_after_failure() const { return state_after_failure_; }

 private:
  /// The database may have rolled back by itself; then this fails and changes nothing.
  void RollbackQuietly() {
    try {
      Rollback();
    } catch (const std::exception&) {  // the first failure is the one to tell
    }
  }

  ConnectionState state_after_failure_ = ConnectionState::kUsable;
};

/// Opens connections to one store. Thread-safe.
class AnchorDatabase {
 public:
  virtual ~AnchorDatabase() = default;
  virtual const std::string& name() const = 0;
  virtual Result<std::unique_ptr<AnchorTables>> Connect() = 0;
};

/// The state in a row, if its checksum holds, it decodes, and it agrees with its keys.
/// Errors: Corrupt naming store and revision.
Result<AnchorState> VerifyRow(const std::string& store, const LogRow& row);

/// The row of the log and the row of the index that say this state.
LogRow ToLogRow(const AnchorState& state, std::uint64_t previous);
PlaceRow ToPlaceRow(const AnchorState& state);

/// The states of these revisions, in the order asked. Errors: Corrupt, also when one is missing.
Result<std::vector<AnchorState>> LoadVerified(AnchorTables& tables,
                                              const std::vector<std::uint64_t>& revisions);

/// The same for revisions to which the index points: live anchors, of this room if one is given.
Result<std::vector<AnchorRecord>> LoadLive(AnchorTables& tables, const std::optional<RoomId>& room,
                                           const std::vector<std::uint64_t>& revisions);

}  // namespace waymark::content::internal

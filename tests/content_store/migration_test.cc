// SPDX-License-Identifier: Apache-2.0
// Stores that earlier versions of this program wrote.
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/wait.h>

#include <csignal>

#include "content_store/anchor_rules.h"
#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/cell_index.h"
#include "content_store/store_admin.h"
#include "content_store/store_check.h"
#include "mapping/base/content_hash.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// An anchor as version 1 knew them.
AnchorRecord OldAnchor(std::uint64_t n) {
  AnchorRecord record = MakeAnchor(n);
  record.expires_utc_ms.reset();
  record.unsupported_since_epoch.reset();
  record.visibility = AnchorVisibility::kRoom;
  record.editing = AnchorEditing::kEveryone;
  return record;
}

/// Writes a store of version 1, statement by statement as that version did.
class OldStore {
 public:
  explicit OldStore(const std::filesystem::path& file) {
    EXPECT_EQ(sqlite3_open(file.c_str(), &database_), SQLITE_OK);
    Run("CREATE TABLE anchors (room TEXT NOT NULL, id TEXT NOT NULL, revision INTEGER NOT NULL, "
        "cell INTEGER, PRIMARY KEY (room, id)) WITHOUT ROWID");
    Run("CREATE INDEX anchors_by_cell ON anchors (room, cell, revision) WHERE cell IS NOT NULL");
    Run("CREATE TABLE changes (revision INTEGER PRIMARY KEY, room TEXT NOT NULL, id TEXT NOT NULL, "
        "state BLOB NOT NULL, checksum INTEGER NOT NULL)");
    Run("PRAGMA application_id = 0x574d414e");
    Run("PRAGMA user_version = 1");
  }
  ~OldStore() { sqlite3_close(database_); }

  void Write(AnchorRecord record, const std::string& creation, bool is_deleted = false) {
    record.revision = ++revision_;
    const internal::AnchorState state{record, creation, is_deleted};
    std::string bytes = internal::EncodeForFingerprint(state);
    EXPECT_EQ(bytes[0], 1) << "the format of version 1";
    const auto checksum = static_cast<std::int64_t>(
        Checksum({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}));
    const std::string hex =
        fmt::format("{:02x}", fmt::join(std::vector<std::uint8_t>(bytes.begin(), bytes.end()), ""));
    const std::string cell =
        is_deleted ? "NULL"
                   : std::to_string(internal::CellOf(
                         {record.place.latitude.radians(), record.place.longitude.radians()}));
    Run(fmt::format("INSERT INTO changes VALUES ({}, '{}', '{}', x'{}', {})", revision_,
                    record.room.text(), record.id.text(), hex, checksum));
    Run(fmt::format("INSERT OR REPLACE INTO anchors VALUES ('{}', '{}', {}, {})",
                    record.room.text(), record.id.text(), revision_, cell));
  }
  void Run(const std::string& statement) {
    EXPECT_EQ(sqlite3_exec(database_, statement.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database_);
  }

 private:
  sqlite3* database_ = nullptr;
  std::uint64_t revision_ = 0;
};

class Migration1 : public testing::Test {
 protected:
  void SetUp() override {
    OldStore old(file_);
    for (std::uint64_t n = 0; n < 40; ++n) {
      const AnchorRecord record = OldAnchor(n);
      old.Write(record, ContentFingerprint(record));
      AnchorRecord changed = record;
      changed.payload += " again";
      changed.changed_utc_ms += 5;
      if (n % 3 == 0) old.Write(changed, ContentFingerprint(record));
      if (n % 5 == 0) old.Write(record, "", true);
    }
  }

  void ExpectAllThere(AnchorStore& store) {
    for (std::uint64_t n = 0; n < 40; ++n) {
      AnchorRecord record = OldAnchor(n);
      const auto found = store.Find(record.room, record.id);
      ASSERT_TRUE(found) << ToString(found.error());
      ASSERT_EQ(found->has_value(), n % 5 != 0);
      if (!*found) continue;
      if (n % 3 == 0) {
        record.payload += " again";
        record.changed_utc_ms += 5;
      }
      EXPECT_TRUE(SameAnchor(**found, record));
    }
  }

  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "anchors.db";
};

TEST_F(Migration1, KeepsAllAndIsSoundAfterwards) {
  {
    auto store = OpenSqliteStore(file_);
    ASSERT_TRUE(store) << ToString(store.error());
    ExpectAllThere(**store);
    const auto changes = (*store)->LoadChanges(0, 1000);
    ASSERT_TRUE(changes) << ToString(changes.error());
    EXPECT_EQ(changes->size(), 40u + 14 + 8);
    // What the new tables know of the old states is used.
    EXPECT_EQ((*store)->Query({.room = RoomId("room"), .limit = 1000})->anchors.size(), 32u);
    const TimeSpan span{1'700'000'000'002, 1'700'000'000'009};
    EXPECT_EQ((*store)->Query({.room = RoomId("room"), .changed = span})->anchors.size(), 5u)
        << "2, 4, 7, 8 and, changed later, 3";
    EXPECT_EQ(Applied((*store)->Create(OldAnchor(1))).revision, 4u) << "a retry is recognised";
    EXPECT_FALSE(Conflict((*store)->Create(OldAnchor(5))).current) << "a spent id stays spent";
  }
  const auto check = CheckSqliteStore(file_);
  ASSERT_TRUE(check) << ToString(check.error());
  EXPECT_THAT(check->problems, IsEmpty());
  EXPECT_EQ(check->anchors, 32u);
  EXPECT_EQ(check->deleted, 8u);
}

TEST_F(Migration1, WaitsToBeAskedWhereOneOnlyLooks) {
  const auto refused = OpenSqliteStore(file_, {.migration = Migration::kRefuse});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(refused.error().message, HasSubstr("migrate"));
  EXPECT_TRUE(MigrateStore(file_.string()).value());
  EXPECT_FALSE(MigrateStore(file_.string()).value()) << "once is enough";
  EXPECT_TRUE(OpenSqliteStore(file_, {.migration = Migration::kRefuse}));
}

TEST_F(Migration1, ADamagedStateStopsItAndLeavesTheOldStore) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file_.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "UPDATE changes SET checksum = checksum + 1 WHERE revision = 4", nullptr,
               nullptr, nullptr);
  const auto failed = OpenSqliteStore(file_);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(failed.error().message, HasSubstr("revision 4"));
  sqlite3_exec(database, "UPDATE changes SET checksum = checksum - 1 WHERE revision = 4", nullptr,
               nullptr, nullptr);
  sqlite3_close(database);
  auto store = OpenSqliteStore(file_);
  ASSERT_TRUE(store) << ToString(store.error());
  ExpectAllThere(**store);
}

TEST_F(Migration1, AKilledOneIsDoneByTheNext) {
  for (int trial = 0; trial < 10; ++trial) {
    const pid_t child = ::fork();
    if (child == 0) {
      (void)OpenSqliteStore(file_);
      ::_exit(0);
    }
    const auto until = std::chrono::steady_clock::now() + std::chrono::microseconds(500 * trial);
    while (std::chrono::steady_clock::now() < until) continue;
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
  }
  auto store = OpenSqliteStore(file_);
  ASSERT_TRUE(store) << ToString(store.error());
  ExpectAllThere(**store);
  EXPECT_THAT(CheckSqliteStore(file_)->problems, IsEmpty());
}

}  // namespace
}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
// What only the SQLite store has: a file, its schema, other processes.
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/mman.h>
#include <sys/wait.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "content_store/anchor_store.h"
#include "content_store/store_check.h"
#include "mapping/base/file.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class SqliteStore : public testing::Test {
 protected:
  /// Runs SQL of ours on the file, past the store.
  sqlite3* Raw(const std::string& statements) {
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(file_.c_str(), &database), SQLITE_OK);
    char* message = nullptr;
    EXPECT_EQ(sqlite3_exec(database, statements.c_str(), nullptr, nullptr, &message), SQLITE_OK)
        << message;
    return database;
  }
  void ChangeFile(const std::string& statements) { sqlite3_close(Raw(statements)); }

  Error OpenFails(OpenMode mode = OpenMode::kCreateIfAbsent) {
    const auto store = OpenSqliteStore(file_, {.mode = mode});
    EXPECT_FALSE(store);
    return store ? Error{} : store.error();
  }

  TemporaryFolder folder_;
  const fs::path file_ = folder_.path() / "with space & 'quote' = é.db";
};

TEST_F(SqliteStore, KeepsAnchorsAndRevisionsWhenReopened) {
  const AnchorRecord record = Applied(OpenSqliteStore(file_).value()->Create(MakeAnchor(1)));
  const auto store = OpenSqliteStore(file_, {.mode = OpenMode::kExisting});
  ASSERT_TRUE(store) << ToString(store.error());
  EXPECT_TRUE(SameAnchor((*store)->Find(record.room, record.id)->value(), record));
  EXPECT_EQ(Applied((*store)->Create(MakeAnchor(2))).revision, 2u);
  EXPECT_TRUE(fs::exists(file_)) << "the path means what it says";
}

TEST_F(SqliteStore, SaysWhatCannotBeOpened) {
  EXPECT_EQ(OpenFails(OpenMode::kExisting).code, ErrorCode::kNotFound);
  EXPECT_FALSE(fs::exists(file_)) << "looking must not create";
  EXPECT_EQ(OpenSqliteStore(folder_.path() / "no" / "folder.db").error().code,
            ErrorCode::kUnavailable);
  EXPECT_EQ(OpenSqliteStore(folder_.path()).error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(OpenSqliteStore(folder_.path() / "a\"b").error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(OpenSqliteStore(file_, {.busy_timeout_s = -1}).error().code,
            ErrorCode::kInvalidArgument);
}

TEST_F(SqliteStore, RefusesAFileThatIsNoDatabase) {
  ASSERT_TRUE(StoreFileAtomically(file_, std::string(5000, 'x')));
  const Error error = OpenFails();
  EXPECT_EQ(error.code, ErrorCode::kCorrupt);
  EXPECT_THAT(error.message,
              AllOf(HasSubstr(file_.string()), HasSubstr("expected an anchor store")));
}

TEST_F(SqliteStore, RefusesTheDatabaseOfAnotherProgramAndLeavesItAlone) {
  ChangeFile("CREATE TABLE customers (name TEXT)");
  const auto before = LoadFile(file_).value();
  const Error error = OpenFails();
  EXPECT_EQ(error.code, ErrorCode::kCorrupt);
  EXPECT_THAT(error.message, HasSubstr("another program"));
  EXPECT_EQ(LoadFile(file_).value(), before);
}

TEST_F(SqliteStore, RefusesANewerSchemaAndNamesBothVersions) {
  Applied(OpenSqliteStore(file_).value()->Create(MakeAnchor(1)));
  ChangeFile("PRAGMA user_version = 7");
  const Error error = OpenFails();
  EXPECT_EQ(error.code, ErrorCode::kUnsupported);
  EXPECT_THAT(error.message, AllOf(HasSubstr("version 2"), HasSubstr("found 7")));
}

TEST_F(SqliteStore, RefusesASchemaWithSomethingSlippedIn) {
  Applied(OpenSqliteStore(file_).value()->Create(MakeAnchor(1)));
  ChangeFile("CREATE TRIGGER spy AFTER INSERT ON states BEGIN DELETE FROM places; END");
  EXPECT_EQ(OpenFails().code, ErrorCode::kCorrupt);
  ChangeFile("DROP TRIGGER spy");
  EXPECT_TRUE(OpenSqliteStore(file_));
}

TEST_F(SqliteStore, AProcessKilledBeforeTheSchemaLeavesAFileThatCanBeUsed) {
  ChangeFile("PRAGMA journal_mode = WAL");
  Applied(OpenSqliteStore(file_).value()->Create(MakeAnchor(1)));
}

TEST_F(SqliteStore, AWriteWaitsForAnotherProcessAndThenSaysSo) {
  auto store = OpenSqliteStore(file_, {.busy_timeout_s = 0});
  ASSERT_TRUE(store);
  sqlite3* other = Raw("BEGIN IMMEDIATE");
  const auto refused = (*store)->Create(MakeAnchor(1));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(refused.error().message, HasSubstr("another process is writing"));
  EXPECT_TRUE((*store)->LoadRoom(RoomId("room"))) << "readers do not wait";
  sqlite3_close(other);
  Applied((*store)->Create(MakeAnchor(1)));
}

TEST_F(SqliteStore, ItsLogStaysSmallAlsoUnderReadersWhoNeverPause) {
  constexpr int kPages = 100;
  auto store = OpenSqliteStore(file_, {.checkpoint_pages = kPages, .limits = StoreLimits::None()});
  ASSERT_TRUE(store);
  std::atomic<bool> is_ending = false;
  std::vector<std::jthread> readers;
  for (int r = 0; r < 3; ++r) {
    readers.emplace_back([&] {
      while (!is_ending) EXPECT_TRUE((*store)->LoadRoom(RoomId("room")));
    });
  }
  std::uintmax_t largest_bytes = 0;
  for (std::uint64_t n = 0; n < 600; ++n) {  // about 7 pages each
    Applied((*store)->Create(MakeAnchor(n)));
    largest_bytes = std::max(largest_bytes, fs::file_size(file_.string() + "-wal"));
  }
  is_ending = true;
  readers.clear();
  // All that was written are 18 MB, which a log that is never begun anew would hold. A busy machine
  // holds readers up for longer than the writer waits, again and again.
  EXPECT_LT(largest_bytes, std::uintmax_t{20} * kPages * 4096);
}

TEST_F(SqliteStore, CheckFindsWhatReadingCannotSee) {
  Applied(OpenSqliteStore(file_).value()->Create(MakeAnchor(1)));
  Applied(OpenSqliteStore(file_).value()->Create(MakeAnchor(2)));
  const auto problems = [&] {
    const auto check = CheckSqliteStore(file_);
    return check ? check->problems : std::vector<std::string>{ToString(check.error())};
  };
  EXPECT_THAT(problems(), testing::IsEmpty());
  ChangeFile("UPDATE places SET cell = cell + 4 WHERE revision = 1");
  EXPECT_THAT(problems(), testing::Contains(HasSubstr("cell")));
  ChangeFile("DELETE FROM usage WHERE owner = 'device-2'");
  EXPECT_THAT(problems(), testing::Contains(HasSubstr("usage of owner device-2")));
  ChangeFile("DELETE FROM places WHERE revision = 1");
  EXPECT_THAT(problems(), testing::Contains(HasSubstr("misses 1")));
  ChangeFile("DELETE FROM states WHERE revision = 1");
  EXPECT_THAT(problems(), testing::Contains(HasSubstr("revision 1")));
  const auto log = OpenSqliteStore(file_).value()->LoadChanges(0, 10);
  ASSERT_FALSE(log);
  EXPECT_THAT(log.error().message, HasSubstr("expected revision 1 in the log, found 2"));
}

TEST_F(SqliteStore, AStateUnderForeignKeysIsNotServed) {
  {
    auto store = OpenSqliteStore(file_);
    Applied((*store)->Create(MakeAnchor(1)));
    Applied((*store)->Create(MakeAnchor(2)));
  }
  ChangeFile(
      "UPDATE states SET state = (SELECT state FROM states WHERE revision = 2), "
      "checksum = (SELECT checksum FROM states WHERE revision = 2) WHERE revision = 1");
  const auto found = OpenSqliteStore(file_).value()->Find(RoomId("room"), IdOf(1));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kCorrupt);
}

/// What two processes share in the race below.
struct Race {
  static constexpr int kRounds = 40;
  std::atomic<int> at_start[kRounds];
  std::atomic<int> wins[kRounds];
};

/// One of two processes: in every round both update the same revision. Returns an exit status.
int RunRacer(const fs::path& file, Race& race) {
  auto store = OpenSqliteStore(file);
  if (!store) return 1;
  for (int round = 0; round < Race::kRounds; ++round) {
    auto current = (*store)->Find(RoomId("room"), IdOf(1));
    if (!current || !*current) return 2;
    ++race.at_start[round];
    while (race.at_start[round] < 2) std::this_thread::yield();
    (*current)->payload = fmt::format("process {} round {}", ::getpid(), round);
    const auto outcome = (*store)->Update(**current, (*current)->revision);
    if (!outcome) return 3;
    race.wins[round] += std::holds_alternative<AnchorRecord>(*outcome) ? 1 : 0;
    // Nobody reads the next revision before both have tried this one.
    ++race.at_start[round];
    while (race.at_start[round] < 4) std::this_thread::yield();
  }
  return 0;
}

TEST_F(SqliteStore, OfTwoProcessesOnOneRevisionExactlyOneWins) {
  Applied(OpenSqliteStore(file_).value()->Create(MakeAnchor(1)));
  void* shared =
      ::mmap(nullptr, sizeof(Race), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  Race& race = *new (shared) Race{};
  pid_t children[2];
  for (pid_t& child : children) {
    child = ::fork();
    if (child == 0) ::_exit(RunRacer(file_, race));
  }
  for (const pid_t child : children) {
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
  }
  for (const auto& wins : race.wins) EXPECT_EQ(wins, 1);
  EXPECT_EQ(OpenSqliteStore(file_).value()->LoadChanges(0, 1000)->size(), 1u + Race::kRounds);
  ::munmap(shared, sizeof(Race));
}

}  // namespace
}  // namespace waymark::content

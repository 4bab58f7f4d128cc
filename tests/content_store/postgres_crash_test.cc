// SPDX-License-Identifier: Apache-2.0
// The database server goes down as in a crash while clients write.
#include <gmock/gmock.h>

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "content_store/store_check.h"
#include "tests/content_store/killed_compaction.h"
#include "tests/content_store/killed_writer.h"
#include "tests/content_store/postgres_server.h"

namespace waymark::content {
namespace {

using testing::IsEmpty;

class PostgresCrash : public testing::Test {
 protected:
  void SetUp() override {
    if (!SharedPostgres()) GTEST_SKIP() << SharedPostgres().error().message;
    server_ = SharedPostgres()->get();
    ASSERT_TRUE(server_->Execute("DROP SCHEMA IF EXISTS waymark CASCADE"));
    auto store = OpenPostgresStore(server_->Uri(), {.limits = StoreLimits::None()});
    ASSERT_TRUE(store) << ToString(store.error());
    store_ = *std::move(store);
  }

  /// One write; true if it was acknowledged.
  bool Tell(std::uint64_t anchor, std::uint64_t version, const Result<WriteOutcome>& outcome,
            std::uint64_t& revision) {
    if (!outcome) {
      EXPECT_EQ(outcome.error().code, ErrorCode::kUnavailable) << outcome.error().message;
      return false;
    }
    const auto* record = std::get_if<AnchorRecord>(&*outcome);
    if (record == nullptr) return false;  // an earlier attempt that was not heard of
    revision = record->revision;
    const std::lock_guard lock(mutex_);
    acknowledged_.Add({anchor, version, revision});
    ++count_;
    return true;
  }

  void WriteUntilTold(std::uint64_t first_anchor) {
    for (std::uint64_t anchor = first_anchor; !is_ending_; ++anchor) {
      std::uint64_t revision = 0;
      if (!Tell(anchor, 0, store_->Create(Version(anchor, 0)), revision)) continue;
      if (!Tell(anchor, 1, store_->Update(Version(anchor, 1), revision), revision)) continue;
      if (anchor % 3 == 0) {
        Tell(anchor, kDeleted, store_->Delete(RoomId("room"), IdOf(anchor), revision), revision);
      }
    }
  }

  PostgresServer* server_ = nullptr;
  std::unique_ptr<AnchorStore> store_;
  std::mutex mutex_;
  AcknowledgedWrites acknowledged_;  // guarded by mutex_
  std::atomic<std::size_t> count_ = 0;
  std::atomic<bool> is_ending_ = false;
};

TEST_F(PostgresCrash, LeavesEveryAcknowledgedWriteAndTheStoreGoesOnByItself) {
  const char* wanted = std::getenv("WAYMARK_RESTARTS");
  const int restarts = wanted != nullptr ? std::atoi(wanted) : 2;
  std::vector<std::jthread> writers;
  for (std::uint64_t w = 0; w < 4; ++w) {
    writers.emplace_back([&, w] { WriteUntilTold(1'000'000 * w); });
  }
  for (int trial = 0; trial < restarts && !HasFailure(); ++trial) {
    // In full swing, at a moment that differs.
    const std::size_t target = count_ + 50 + static_cast<std::size_t>(trial) * 7 % 40;
    while (count_ < target) std::this_thread::yield();
    const auto restarted = server_->CrashAndRestart();
    ASSERT_TRUE(restarted) << ToString(restarted.error());
  }
  const std::size_t target = count_ + 50;  // it goes on without being opened again
  while (count_ < target) std::this_thread::yield();
  is_ending_ = true;
  writers.clear();
  acknowledged_.CompareWith(*store_);
  const auto check = CheckStore(server_->Uri());
  ASSERT_TRUE(check) << ToString(check.error());
  EXPECT_THAT(check->problems, IsEmpty());
  fmt::print(
      "{} restarts, {} acknowledged writes: {} lost, {} torn; {} more had committed "
      "unheard\n",
      restarts, acknowledged_.size(), acknowledged_.lost(), acknowledged_.torn(),
      acknowledged_.seen() - acknowledged_.size());
}

TEST_F(PostgresCrash, AKilledWriterLeavesEveryAcknowledgedWriteAndNothingTorn) {
  const auto open = [&] {
    return OpenPostgresStore(server_->Uri(), {.limits = StoreLimits::None()});
  };
  const int kills = KillWriters(open, 10, acknowledged_);
  // The last one's server process may still be at its last write: another one waits for its end.
  Applied(store_->Create(Version(999'999'999, 0)));
  acknowledged_.CompareWith(*store_);
  const auto check = CheckStore(server_->Uri());
  ASSERT_TRUE(check) << ToString(check.error());
  EXPECT_THAT(check->problems, IsEmpty());
  EXPECT_EQ(check->revision, acknowledged_.seen());
  fmt::print("{} kills, {} acknowledged writes: {} lost, {} torn; {} more had committed unheard\n",
             kills, acknowledged_.size(), acknowledged_.lost(), acknowledged_.torn(),
             acknowledged_.seen() - acknowledged_.size() - 1);
}

TEST_F(PostgresCrash, AKilledCompactionLosesNothing) { KillCompactions(server_->Uri(), 6); }

TEST_F(PostgresCrash, DamageIsFoundAndNotServed) {
  for (std::uint64_t n = 0; n < 5; ++n) Applied(store_->Create(MakeAnchor(n)));
  ASSERT_TRUE(
      server_->Execute("UPDATE waymark.states SET state = set_byte(state, 100, 255 - "
                       "get_byte(state, 100)) WHERE revision = 3"));
  const auto found = store_->Find(RoomId("room"), IdOf(2));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kCorrupt);
  EXPECT_FALSE(store_->LoadRoom(RoomId("room")));
  EXPECT_TRUE(store_->Find(RoomId("room"), IdOf(1)));
  EXPECT_THAT(CheckStore(server_->Uri())->problems,
              testing::Contains(testing::HasSubstr("revision 3: expected checksum")));
  ASSERT_TRUE(server_->Execute("DELETE FROM waymark.states WHERE revision = 4"));
  EXPECT_FALSE(store_->LoadChanges(3, 10));
  EXPECT_FALSE(store_->Find(RoomId("room"), IdOf(3)));
  ASSERT_TRUE(server_->Execute("DELETE FROM waymark.places WHERE revision = 5"));
  EXPECT_THAT(CheckStore(server_->Uri())->problems,
              testing::AllOf(testing::Contains(testing::HasSubstr("expected revision 4")),
                             testing::Contains(testing::HasSubstr("usage of owner"))));
}

TEST_F(PostgresCrash, SaysWhatCannotBeOpened) {
  const std::string nowhere = "postgresql://me:secret@127.0.0.1:1/db?connect_timeout=2";
  const auto refused = OpenStore(nowhere);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("postgresql://me@127.0.0.1:1/db"));
  EXPECT_THAT(refused.error().message, testing::Not(testing::HasSubstr("secret")));
  ASSERT_TRUE(server_->Execute("UPDATE waymark.facts SET value = 9 WHERE name = 'schema_version'"));
  EXPECT_EQ(OpenPostgresStore(server_->Uri()).error().code, ErrorCode::kUnsupported);
  ASSERT_TRUE(server_->Execute("DROP SCHEMA waymark CASCADE"));
  EXPECT_EQ(OpenPostgresStore(server_->Uri(), {.mode = OpenMode::kExisting}).error().code,
            ErrorCode::kNotFound);
  EXPECT_TRUE(OpenPostgresStore(server_->Uri()));
}

}  // namespace
}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
// Compaction removes what was superseded and nothing else.
#include <gmock/gmock.h>
#include <sqlite3.h>

#include "content_store/store_admin.h"
#include "content_store/store_check.h"
#include "tests/content_store/anchor_fixtures.h"
#include "tests/content_store/killed_compaction.h"

namespace waymark::content {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class Compaction : public testing::Test {
 protected:
  void SetUp() override {
    auto opened = OpenSqliteStore(file_);
    ASSERT_TRUE(opened);
    store_ = *std::move(opened);
    Write(0, 30);
  }
  /// Each anchor is created and updated; every fifth is deleted: 11 revisions for 5 anchors.
  void Write(std::uint64_t first, std::uint64_t end) {
    for (std::uint64_t n = first; n < end; ++n) {
      AnchorRecord record = Applied(store_->Create(MakeAnchor(n)));
      record.payload += " again";
      record = Applied(store_->Update(record, record.revision));
      if (n % 5 == 0) Applied(store_->Delete(record.room, record.id, record.revision));
    }
  }
  CompactionReport Compact(std::uint64_t keep) {
    const auto report = CompactStore(file_.string(), keep);
    EXPECT_TRUE(report) << ToString(report.error());
    return report.value();
  }
  std::vector<std::string> Problems() {
    const auto check = CheckSqliteStore(file_);
    return check ? check->problems : std::vector<std::string>{ToString(check.error())};
  }
  void Damage(const char* statement) {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(file_.c_str(), &database), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(database, statement, nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(database);
  }

  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "anchors.db";
  std::unique_ptr<AnchorStore> store_;
};

TEST_F(Compaction, KeepsEveryAnchorEverySpentIdAndTheRevision) {
  const auto before = store_->LoadRoom(RoomId("room"));
  EXPECT_EQ(before->revision, 66u);
  const CompactionReport report = Compact(0);
  EXPECT_EQ(report.states_before, 66u);
  EXPECT_EQ(report.states_after, 30u);
  EXPECT_EQ(report.compacted_through, 66u);
  EXPECT_THAT(Problems(), IsEmpty());
  const auto after = store_->LoadRoom(RoomId("room"));
  ASSERT_TRUE(after) << ToString(after.error());
  EXPECT_EQ(after->revision, before->revision);
  ASSERT_EQ(after->anchors.size(), before->anchors.size());
  for (std::size_t i = 0; i < after->anchors.size(); ++i) {
    EXPECT_TRUE(SameAnchor(after->anchors[i], before->anchors[i]));
  }
  EXPECT_FALSE(Conflict(store_->Create(MakeAnchor(5))).current);
  // Who joins late meets the latest change of each anchor, and all that comes after.
  Write(30, 35);
  const auto changes = store_->LoadChanges(0, 1000);
  ASSERT_TRUE(changes) << ToString(changes.error());
  EXPECT_EQ(changes->size(), 30u + 11);
  EXPECT_THAT(Problems(), IsEmpty());
}

TEST_F(Compaction, MayBeRepeatedAndLeavesTheLatestRevisionsAlone) {
  EXPECT_EQ(Compact(30).compacted_through, 36u);
  EXPECT_THAT(Problems(), IsEmpty());
  Write(30, 40);
  EXPECT_EQ(Compact(1000).states_after, Compact(1000).states_before);
  AnchorRecord record = store_->Find(RoomId("room"), IdOf(1))->value();
  record.payload = "superseded after a compaction";
  Applied(store_->Update(record, record.revision));
  const CompactionReport all = Compact(0);
  EXPECT_EQ(all.states_after, 40u);
  EXPECT_THAT(Problems(), IsEmpty());
}

TEST_F(Compaction, APageOfAnOlderPictureIsRefused) {
  auto page = store_->Query({.room = RoomId("room"), .limit = 3});
  ASSERT_TRUE(page->next);
  Write(30, 35);
  EXPECT_TRUE(store_->Query({.room = RoomId("room"), .limit = 3, .after = page->next}));
  Compact(0);
  const auto next = store_->Query({.room = RoomId("room"), .limit = 3, .after = page->next});
  ASSERT_FALSE(next);
  EXPECT_EQ(next.error().code, ErrorCode::kConflict);
  EXPECT_THAT(next.error().message, HasSubstr("begin again"));
}

TEST(KilledCompaction, LosesNothing) {
  const TemporaryFolder folder;
  KillCompactions((folder.path() / "anchors.db").string(), 6);
}

TEST_F(Compaction, CheckMissesNoStateThatIsGone) {
  Compact(10);
  Damage(
      "DELETE FROM states WHERE revision = (SELECT max(revision) FROM states WHERE revision < "
      "50)");
  EXPECT_THAT(Problems(), testing::Contains(HasSubstr("states up to revision 56")));
  const auto changes = store_->LoadChanges(56, 1000);
  EXPECT_EQ(changes->size(), 10u);
  Damage("DELETE FROM states WHERE revision = 60");
  EXPECT_FALSE(store_->LoadChanges(56, 1000));
}

}  // namespace
}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
// A disk that fails a write or a sync at every possible place, and one that lies about its syncs.
#include <gmock/gmock.h>

#include <cstdlib>

#include "content_store/store_check.h"
#include "mapping/base/file.h"
#include "tests/content_store/acknowledged.h"
#include "tests/content_store/faulty_disk.h"

namespace waymark::content {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

int TrialsWanted(int usual) {
  const char* wanted = std::getenv("WAYMARK_FAULTS");
  return wanted != nullptr ? std::atoi(wanted) : usual;
}

/// The n-th step of a mixture, told if it was acknowledged.
void Step(AnchorStore& store, std::uint64_t n, std::vector<AnchorRecord>& live,
          AcknowledgedWrites& acknowledged) {
  const auto tell = [&](std::uint64_t anchor, std::uint64_t version,
                        const Result<WriteOutcome>& outcome) -> const AnchorRecord* {
    if (!outcome) {
      EXPECT_EQ(outcome.error().code, ErrorCode::kUnavailable) << outcome.error().message;
      return nullptr;
    }
    const auto* record = std::get_if<AnchorRecord>(&*outcome);
    if (record != nullptr) acknowledged.Add({anchor, version, record->revision});
    return record;
  };
  const auto outcome = store.Create(Version(n, 0));
  const AnchorRecord* created = tell(n, 0, outcome);
  if (created == nullptr) return;
  live.push_back(*created);
  if (n % 3 == 0) {
    AnchorRecord& record = live[n * 31 % live.size()];
    unsigned long anchor = 0;
    std::sscanf(record.payload.c_str(), "%lu", &anchor);
    const auto updated = store.Update(Version(anchor, record.epoch), record.revision);
    if (const AnchorRecord* now = tell(anchor, record.epoch, updated)) record = *now;
  }
}

class FaultyDisks : public testing::Test {
 protected:
  struct Trial {
    bool has_struck;
    std::size_t acknowledged, lost, torn;
  };

  /// Some writes with one fault among them; then the store is opened again on a sound disk.
  Trial Run(DiskFault fault, std::uint64_t at) {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "anchors.db";
    FaultyDisk disk(folder.path());
    AcknowledgedWrites acknowledged;
    std::vector<AnchorRecord> live;
    auto store = OpenSqliteStore(file);
    EXPECT_TRUE(store) << ToString(store.error());
    for (std::uint64_t n = 0; n < 4; ++n) Step(**store, n, live, acknowledged);
    disk.Plan(fault, at);
    for (std::uint64_t n = 4; n < 16; ++n) Step(**store, n, live, acknowledged);
    const bool has_struck = disk.has_struck();
    disk.Plan(DiskFault::kNone, 0);
    store = Error{};  // closed before the next is opened
    auto reopened = OpenSqliteStore(file);
    EXPECT_TRUE(reopened) << ToString(reopened.error());
    if (!reopened) return {has_struck, 0, 0, 0};
    acknowledged.CompareWith(**reopened);
    Applied((*reopened)->Create(Version(1000, 0)));
    EXPECT_THAT(CheckSqliteStore(file)->problems, IsEmpty());
    return {has_struck, acknowledged.size(), acknowledged.lost(), acknowledged.torn()};
  }
};

TEST_F(FaultyDisks, AFailureAnywhereLosesNothingAcknowledged) {
  const int most = TrialsWanted(12);
  for (const auto& [fault, name] :
       {std::pair(DiskFault::kFull, "full"), std::pair(DiskFault::kTorn, "torn write"),
        std::pair(DiskFault::kWrite, "failed write"), std::pair(DiskFault::kSync, "failed sync")}) {
    Trial sum{};
    int struck = 0;
    for (int at = 1; at <= most && !HasFailure(); ++at) {
      SCOPED_TRACE(fmt::format("{} at operation {}", name, at));
      const Trial trial = Run(fault, static_cast<std::uint64_t>(at));
      if (!trial.has_struck) break;
      ++struck;
      sum.acknowledged += trial.acknowledged;
      sum.lost += trial.lost;
      sum.torn += trial.torn;
    }
    EXPECT_GT(struck, 9);
    fmt::print("{}: {} trials, {} acknowledged writes: {} lost, {} torn\n", name, struck,
               sum.acknowledged, sum.lost, sum.torn);
  }
}

TEST_F(FaultyDisks, ALyingDiskMayForgetButNeverServesAWrongRecord) {
  std::mt19937_64 random(29);
  int opened = 0, refused = 0;
  std::size_t forgotten = 0;
  const int trials = TrialsWanted(20);
  for (int trial = 0; trial < trials && !HasFailure(); ++trial) {
    const TemporaryFolder folder;
    const fs::path live_folder = folder.path() / "live", image = folder.path() / "image";
    ASSERT_TRUE(CreateFolders(live_folder));
    ASSERT_TRUE(CreateFolders(image));
    AcknowledgedWrites acknowledged;
    std::vector<AnchorRecord> live;
    {
      FaultyDisk disk(live_folder);
      auto store = OpenSqliteStore(live_folder / "anchors.db");
      ASSERT_TRUE(store) << ToString(store.error());
      for (std::uint64_t n = 0; n < 6; ++n) Step(**store, n, live, acknowledged);
      disk.Plan(DiskFault::kLostSync, 1 + random() % 20);
      const std::uint64_t last = 8 + random() % 60;
      for (std::uint64_t n = 6; n < last; ++n) Step(**store, n, live, acknowledged);
      disk.Cut(image, random);
    }
    auto store = OpenSqliteStore(image / "anchors.db", {.mode = OpenMode::kExisting});
    const auto changes =
        store ? (*store)->LoadChanges(0, 10'000) : Result<std::vector<AnchorChange>>(store.error());
    if (!changes) {
      EXPECT_EQ(changes.error().code, ErrorCode::kCorrupt) << changes.error().message;
      ++refused;
      continue;
    }
    ++opened;
    forgotten += acknowledged.size() - std::min(acknowledged.size(), changes->size());
    for (const AnchorChange& change : *changes) {
      if (!change.record) continue;
      unsigned long anchor = 0;
      std::sscanf(change.record->payload.c_str(), "%lu", &anchor);
      EXPECT_TRUE(SameAnchor(*change.record, Version(anchor, change.record->epoch - 1)));
    }
  }
  EXPECT_GT(opened, 0);
  fmt::print(
      "{} cuts of a disk that lies: {} opened ({} writes forgotten), {} refused as damaged; "
      "no wrong record\n",
      opened + refused, opened, forgotten, refused);
}

}  // namespace
}  // namespace waymark::content

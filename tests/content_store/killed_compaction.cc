// SPDX-License-Identifier: Apache-2.0
#include "tests/content_store/killed_compaction.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <random>

#include "content_store/store_admin.h"
#include "content_store/store_check.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content {
namespace {

using testing::IsEmpty;

constexpr std::uint64_t kAnchors = 3000;

/// Gives every anchor a new state.
void UpdateAll(AnchorStore& store, std::vector<AnchorRecord>& records, int times) {
  for (int i = 0; i < times; ++i) {
    for (AnchorRecord& record : records) ++record.epoch;
    const auto outcomes = store.UpdateMany(records);
    for (std::size_t n = 0; n < records.size(); ++n) records[n] = Applied(outcomes[n]);
  }
}

/// True if it was killed before it ended by itself.
bool CompactAndKill(const std::string& location, std::chrono::microseconds after) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(CompactStore(location, 0) ? 0 : 1);
  const auto until = std::chrono::steady_clock::now() + after;
  while (std::chrono::steady_clock::now() < until) continue;
  ::kill(child, SIGKILL);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0) << "the compaction failed";
  return WIFSIGNALED(status);
}

void ExpectAll(AnchorStore& store, const std::vector<AnchorRecord>& records) {
  const auto room = store.LoadRoom(RoomId("room"));
  ASSERT_TRUE(room) << ToString(room.error());
  std::map<std::string, std::uint64_t> revisions;
  for (const AnchorRecord& record : room->anchors) revisions[record.id.text()] = record.revision;
  EXPECT_EQ(revisions.size(), records.size());
  for (const AnchorRecord& record : records) {
    ASSERT_EQ(revisions[record.id.text()], record.revision) << record.id.text();
  }
}

}  // namespace

void KillCompactions(const std::string& location, int trials) {
  const auto store = OpenStore(location, {.limits = StoreLimits::None()});
  ASSERT_TRUE(store) << ToString(store.error());
  std::vector<AnchorRecord> records;
  for (std::uint64_t n = 0; n < kAnchors; ++n) records.push_back(MakeAnchor(n));
  const auto created = (*store)->CreateMany(records);
  for (std::size_t n = 0; n < records.size(); ++n) records[n] = Applied(created[n]);
  UpdateAll(**store, records, 14);
  std::mt19937_64 random(5);
  int killed = 0;
  for (int trial = 0; trial < trials && !testing::Test::HasFailure(); ++trial) {
    killed += CompactAndKill(location, std::chrono::microseconds(random() % 300'000)) ? 1 : 0;
    ExpectAll(**store, records);
    UpdateAll(**store, records, 1);
    const auto check = CheckStore(location);
    ASSERT_TRUE(check) << ToString(check.error());
    EXPECT_THAT(check->problems, IsEmpty());
  }
  const auto report = CompactStore(location, 0);
  ASSERT_TRUE(report) << ToString(report.error());
  EXPECT_EQ(report->states_after, kAnchors);
  ExpectAll(**store, records);
  EXPECT_THAT(CheckStore(location)->problems, IsEmpty());
  fmt::print("{} compactions killed, {} ended before: nothing lost\n", killed, trials - killed);
}

}  // namespace waymark::content

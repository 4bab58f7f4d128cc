// SPDX-License-Identifier: Apache-2.0
// A writing process is killed at arbitrary moments; what it acknowledged is there.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <random>
#include <thread>

#include "content_store/anchor_store.h"
#include "content_store/store_check.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

struct Acknowledgement {
  std::uint64_t anchor;   // the n of MakeAnchor
  std::uint64_t version;  // 0 created, above: updated; kDeleted: gone
  std::uint64_t revision;
};
constexpr std::uint64_t kDeleted = ~std::uint64_t{0};

/// Every field that an update sets follows from anchor and version.
AnchorRecord Version(std::uint64_t anchor, std::uint64_t version) {
  AnchorRecord record = MakeAnchor(anchor);
  record.payload = fmt::format("{} {} ", anchor, version) +
                   std::string((anchor * 31 + version * 977) % 5000, 'p');
  record.epoch = version + 1;
  return record;
}

/// Writes for ever: creates, updates twice, deletes some, and tells each success.
[[noreturn]] void WriteForEver(AnchorStore& store, std::uint64_t first_anchor, int acknowledge) {
  const auto tell = [&](std::uint64_t anchor, std::uint64_t version, auto&& outcome) {
    const auto* record = outcome ? std::get_if<AnchorRecord>(&*outcome) : nullptr;
    if (record == nullptr) ::_exit(1);
    const Acknowledgement done{anchor, version, record->revision};
    if (::write(acknowledge, &done, sizeof(done)) != sizeof(done)) ::_exit(2);
    return record->revision;
  };
  for (std::uint64_t anchor = first_anchor;; ++anchor) {
    std::uint64_t revision = tell(anchor, 0, store.Create(Version(anchor, 0)));
    for (std::uint64_t version = 1; version <= 2; ++version) {
      revision = tell(anchor, version, store.Update(Version(anchor, version), revision));
    }
    if (anchor % 3 == 0) {
      tell(anchor, kDeleted, store.Delete(RoomId("room"), IdOf(anchor), revision));
    }
  }
}

/// Starts a writer, kills it after some acknowledgements, and returns all that it gave.
std::vector<Acknowledgement> RunAndKill(const fs::path& file, std::uint64_t first_anchor,
                                        std::mt19937_64& random) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    auto store = OpenSqliteStore(file);
    if (!store) ::_exit(3);
    std::jthread second([&] { WriteForEver(**store, first_anchor + 500, ends[1]); });
    WriteForEver(**store, first_anchor, ends[1]);
  }
  ::close(ends[1]);
  std::vector<Acknowledgement> acknowledged;
  Acknowledgement next{};
  const auto read = [&] { return ::read(ends[0], &next, sizeof(next)) == sizeof(next); };
  const auto enough = random() % 60;
  while (acknowledged.size() < enough && read()) acknowledged.push_back(next);
  const auto until = std::chrono::steady_clock::now() +
                     std::chrono::microseconds(random() % 3000);  // into the middle of a write
  while (std::chrono::steady_clock::now() < until) continue;
  ::kill(child, SIGKILL);
  while (read()) acknowledged.push_back(next);
  ::close(ends[0]);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status)) << "the writer gave up by itself: " << WEXITSTATUS(status);
  return acknowledged;
}

TEST(KilledWriter, LeavesEveryAcknowledgedWriteAndNothingTorn) {
  const char* wanted = std::getenv("WAYMARK_KILLS");
  const int kills = wanted != nullptr ? std::atoi(wanted) : 60;
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "anchors.db";
  std::mt19937_64 random(11);
  std::map<std::uint64_t, Acknowledgement> acknowledged;  // by revision
  std::uint64_t seen = 0;
  for (int trial = 0; trial < kills && !testing::Test::HasFailure(); ++trial) {
    for (const auto& done : RunAndKill(file, 1000 * static_cast<std::uint64_t>(trial), random)) {
      EXPECT_TRUE(acknowledged.emplace(done.revision, done).second) << "a revision given twice";
    }
    auto opened = OpenSqliteStore(file);
    ASSERT_TRUE(opened) << ToString(opened.error());
    const auto changes = (*opened)->LoadChanges(seen, 100'000);
    ASSERT_TRUE(changes) << ToString(changes.error());
    std::map<std::uint64_t, const AnchorChange*> found;
    for (const AnchorChange& change : *changes) {
      ASSERT_EQ(change.revision, ++seen) << "a gap in the log";
      found[change.revision] = &change;
      if (change.record) {
        const AnchorRecord& record = *change.record;
        std::uint64_t anchor = 0;
        std::sscanf(record.payload.c_str(), "%lu", &anchor);
        EXPECT_TRUE(SameAnchor(record, Version(anchor, record.epoch - 1))) << "a torn record";
      }
    }
    for (auto done = acknowledged.rbegin(); done != acknowledged.rend(); ++done) {
      if (done->first <= seen - changes->size()) break;  // looked at after an earlier kill
      ASSERT_TRUE(found.contains(done->first)) << "revision " << done->first << " was lost";
      const AnchorChange& change = *found[done->first];
      EXPECT_EQ(change.id, IdOf(done->second.anchor));
      EXPECT_EQ(change.record.has_value(), done->second.version != kDeleted);
      if (change.record) {
        EXPECT_EQ(change.record->epoch, done->second.version + 1);
      }
    }
    EXPECT_LE(changes->size(), found.size());
  }
  const auto check = CheckSqliteStore(file);
  ASSERT_TRUE(check) << ToString(check.error());
  EXPECT_THAT(check->problems, IsEmpty());
  EXPECT_GE(check->revision, acknowledged.size());
  fmt::print("{} kills, {} acknowledged writes, all there; {} more had committed unheard\n", kills,
             acknowledged.size(), check->revision - acknowledged.size());
}

}  // namespace
}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
// What the disk may do: lose everything that was not synced, fail a sync, be full.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include "content_store/anchor_store.h"
#include "content_store/store_check.h"
#include "mapping/base/file.h"
#include "tests/content_store/anchor_fixtures.h"
#include "tests/content_store/sync_watch.h"

namespace waymark::content {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

/// A disk that forgets at a power cut what was not synced, but for some sectors that made it.
class ForgetfulDisk {
 public:
  explicit ForgetfulDisk(fs::path folder) : folder_(std::move(folder)) {}

  /// A synced file keeps its content; a synced folder keeps its names, and forgets the deleted.
  void Synced(const fs::path& path) {
    if (path != folder_) {
      synced_[path.filename().string()] = Load(path);
      return;
    }
    names_.clear();
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names_.insert(entry.path().filename().string());
    }
  }

  /// Writes what a cut now would leave.
  void Cut(const fs::path& into, std::mt19937_64& random) const {
    constexpr std::size_t kSector = 512;
    std::bernoulli_distribution made_it(std::uniform_real_distribution<double>(0, 1)(random));
    for (const std::string& name : names_) {
      if (name.ends_with("-shm")) continue;  // says nothing that recovery does not find out
      const auto present = Load(folder_ / name);
      const auto synced = synced_.find(name);
      auto left = synced == synced_.end() ? std::vector<std::uint8_t>() : synced->second;
      for (std::size_t at = 0; at < present.size(); at += kSector) {
        if (!made_it(random)) continue;
        const std::size_t end = std::min(at + kSector, present.size());
        if (left.size() < end) left.resize(end, 0);
        std::copy(present.begin() + at, present.begin() + end, left.begin() + at);
      }
      std::ofstream(into / name, std::ios::binary)
          .write(reinterpret_cast<const char*>(left.data()), std::ssize(left));
    }
  }

 private:
  static std::vector<std::uint8_t> Load(const fs::path& path) {
    auto bytes = LoadFile(path);
    return bytes ? *std::move(bytes) : std::vector<std::uint8_t>();
  }

  const fs::path folder_;
  std::map<std::string, std::vector<std::uint8_t>> synced_;
  std::set<std::string> names_;
};

class PowerCut : public testing::Test {
 protected:
  /// The store of an image holds all acknowledged writes in order, and nothing torn.
  static void ExpectAllThere(const fs::path& file, const std::vector<AnchorChange>& acknowledged) {
    const auto check = CheckSqliteStore(file);
    ASSERT_TRUE(check) << ToString(check.error());
    EXPECT_THAT(check->problems, IsEmpty());
    auto store = OpenSqliteStore(file, {.mode = OpenMode::kExisting});
    ASSERT_TRUE(store) << ToString(store.error());
    const auto changes = (*store)->LoadChanges(0, 10000);
    ASSERT_TRUE(changes) << ToString(changes.error());
    ASSERT_GE(changes->size(), acknowledged.size());
    EXPECT_LE(changes->size(), acknowledged.size() + 1) << "the write under way may be there";
    for (std::size_t i = 0; i < acknowledged.size(); ++i) {
      const AnchorChange& found = (*changes)[i];
      ASSERT_EQ(found.revision, acknowledged[i].revision);
      ASSERT_EQ(found.record.has_value(), acknowledged[i].record.has_value());
      if (found.record) {
        ASSERT_TRUE(SameAnchor(*found.record, *acknowledged[i].record));
      }
    }
  }

  /// The n-th write of a mixture; payloads are large so that checkpoints come often.
  static AnchorChange Write(AnchorStore& store, std::uint64_t n, std::vector<AnchorRecord>& live) {
    if (n % 4 == 0) {
      live.push_back(Applied(store.Create(MakeAnchor(n))));
      return {live.back().revision, live.back().id, live.back().room, live.back()};
    }
    AnchorRecord& record = live[n * 31 % live.size()];
    if (n % 9 == 5 && live.size() > 1) {
      const AnchorRecord last = Applied(store.Delete(record.room, record.id, record.revision));
      std::swap(record, live.back());
      live.pop_back();
      return {last.revision, last.id, last.room, std::nullopt};
    }
    record.payload = std::string(20'000 + n * 997 % 40'000, static_cast<char>('a' + n % 26));
    record = Applied(store.Update(record, record.revision));
    return {record.revision, record.id, record.room, record};
  }

  TemporaryFolder folder_;
};

TEST_F(PowerCut, LeavesEveryAcknowledgedWrite) {
  const fs::path live = folder_.path() / "live", image = folder_.path() / "image";
  ASSERT_TRUE(CreateFolders(live));
  ForgetfulDisk disk(live);
  std::mt19937_64 random(7);
  std::vector<AnchorChange> acknowledged;
  int syncs = 0, images = 0, checkpoints = 0;  // the first of this write, the others of all
  std::vector<fs::path> cuts;                  // inside the write under way
  SyncWatch watch([&](const std::string& path) {
    if (!path.starts_with(live.string())) return true;
    ++syncs;
    if (path.ends_with("anchors.db") && !acknowledged.empty()) ++checkpoints;
    // Every checkpoint, which syncs more than once, and a sample of the plain commits.
    if (!acknowledged.empty() && (syncs > 1 || random() % 6 == 0)) {
      cuts.push_back(image / std::to_string(++images));
      EXPECT_TRUE(CreateFolders(cuts.back()));
      disk.Cut(cuts.back(), random);
    }
    disk.Synced(path);
    return true;
  });
  auto store = OpenSqliteStore(live / "anchors.db", {.checkpoint_pages = 1000});
  ASSERT_TRUE(store) << ToString(store.error());
  std::vector<AnchorRecord> anchors;
  for (std::uint64_t n = 0; n < 240 && !HasFailure(); ++n) {
    syncs = 0;
    const AnchorChange change = Write(**store, n, anchors);
    EXPECT_GT(syncs, 0) << "acknowledged without a sync";
    for (const fs::path& cut : std::exchange(cuts, {})) {
      ExpectAllThere(cut / "anchors.db", acknowledged);
      fs::remove_all(cut);
    }
    acknowledged.push_back(change);
  }
  EXPECT_GT(checkpoints, 0);
  fmt::print("{} writes, {} checkpoints, {} power cuts inside of them: all there\n",
             acknowledged.size(), checkpoints, images);
}

TEST_F(PowerCut, AFailedSyncIsNotAcknowledgedAndStopsWriting) {
  const fs::path file = folder_.path() / "anchors.db";
  bool disk_works = true;
  SyncWatch watch([&](const std::string& path) {
    return disk_works || !path.starts_with(folder_.path().string());
  });
  {
    auto store = OpenSqliteStore(file);
    ASSERT_TRUE(store);
    Applied((*store)->Create(MakeAnchor(1)));
    disk_works = false;
    const auto failed = (*store)->Create(MakeAnchor(2));
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::kUnavailable);
    disk_works = true;
    const auto after = (*store)->Create(MakeAnchor(3));
    ASSERT_FALSE(after) << "after a failed sync nobody knows what the disk holds";
    EXPECT_THAT(after.error().message, HasSubstr("reopen"));
    EXPECT_EQ((*store)->LoadRoom(RoomId("room"))->anchors.size(), 1u);
  }
  auto store = OpenSqliteStore(file);
  ASSERT_TRUE(store);
  Applied((*store)->Create(MakeAnchor(2)));  // whether or not the first attempt is there
  Applied((*store)->Create(MakeAnchor(3)));
  EXPECT_EQ((*store)->LoadRoom(RoomId("room"))->anchors.size(), 3u);
}

/// In a child: its file sizes are limited. Returns 0 or the line that failed.
int WriteIntoFullDisk(const fs::path& file) {
  std::signal(SIGXFSZ, SIG_IGN);
  auto store = OpenSqliteStore(file);
  if (!store) return __LINE__;
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  const rlim_t unlimited = std::exchange(limit.rlim_cur, 300'000);
  ::setrlimit(RLIMIT_FSIZE, &limit);
  std::uint64_t stored = 0;
  while (true) {
    AnchorRecord record = MakeAnchor(stored);
    record.payload = std::string(20'000, 'x');
    const auto outcome = (*store)->Create(record);
    if (!outcome && outcome.error().code != ErrorCode::kUnavailable) return __LINE__;
    if (!outcome) break;
    if (++stored > 100) return __LINE__;
  }
  if (stored == 0) return __LINE__;
  if ((*store)->LoadRoom(RoomId("room"))->anchors.size() != stored) return __LINE__;
  limit.rlim_cur = unlimited;  // somebody tidied up
  ::setrlimit(RLIMIT_FSIZE, &limit);
  AnchorRecord record = MakeAnchor(stored);
  record.payload = std::string(20'000, 'x');
  if (!(*store)->Create(record)) return __LINE__;
  return (*store)->LoadRoom(RoomId("room"))->anchors.size() == stored + 1 ? 0 : __LINE__;
}

TEST_F(PowerCut, AFullDiskRefusesWritesAndTheStoreSurvives) {
  const fs::path file = folder_.path() / "anchors.db";
  const pid_t child = ::fork();
  if (child == 0) ::_exit(WriteIntoFullDisk(file) % 256);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << "the line of power_cut_test.cc (mod 256) that failed";
  EXPECT_THAT(CheckSqliteStore(file)->problems, IsEmpty());
}

}  // namespace
}  // namespace waymark::content

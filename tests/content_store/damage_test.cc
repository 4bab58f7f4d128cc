// SPDX-License-Identifier: Apache-2.0
// Damaged files: never a crash, never a wrong record, and `check` finds what reading does not.
#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <random>

#include "content_store/anchor_store.h"
#include "content_store/store_check.h"
#include "mapping/base/file.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content {
namespace {

namespace fs = std::filesystem;

class Damage : public testing::Test {
 protected:
  void SetUp() override {
    auto store = OpenSqliteStore(sound_);
    ASSERT_TRUE(store);
    for (std::uint64_t n = 0; n < 60; ++n) {
      AnchorRecord record = Applied((*store)->Create(MakeAnchor(n)));
      history_[record.revision] = record;
      if (n % 4 == 1) {
        record.payload += " again";
        record = Applied((*store)->Update(record, record.revision));
        history_[record.revision] = record;
      }
      if (n % 5 == 2) {
        Applied((*store)->Delete(record.room, record.id, record.revision));
        history_[record.revision + 1] = std::nullopt;
      } else {
        live_.insert_or_assign(record.id, record);
      }
    }
    store->reset();
    bytes_ = LoadFile(sound_).value();
  }

  static constexpr auto kOk = [](ErrorCode code) {
    return code == ErrorCode::kCorrupt || code == ErrorCode::kUnsupported ||
           code == ErrorCode::kUnavailable;
  };

  void ExpectTrue(const AnchorRecord& record) {
    const auto truth = history_.find(record.revision);
    ASSERT_NE(truth, history_.end()) << "an invented revision was served";
    ASSERT_TRUE(truth->second) << "a deleted anchor was served";
    ASSERT_TRUE(SameAnchor(record, *truth->second)) << "a wrong record was served";
  }

  /// Reads all there is. True if every answer was there and right; wrong ones fail the test.
  bool ReadsRight(AnchorStore& store) {
    bool complete = true;
    const auto take = [&](const auto& result, std::size_t expected, const auto& records) {
      if (!result) {
        EXPECT_EQ(result.error().code, ErrorCode::kCorrupt) << result.error().message;
        complete = false;
        return;
      }
      for (const auto& record : records(*result)) ExpectTrue(record);
      complete = complete && records(*result).size() == expected;
    };
    take(store.LoadRoom(kRoom), live_.size(), [](const auto& room) { return room.anchors; });
    take(store.FindNear(kRoom, PlaceAt(47.35, 8.55), 20'000, 1000), live_.size(),
         [](const auto& records) { return records; });
    std::size_t deleted = 0;
    take(store.LoadChanges(0, 1000), history_.size() - 12, [&](const auto& changes) {
      std::vector<AnchorRecord> records;
      for (const AnchorChange& change : changes) {
        if (change.record) records.push_back(*change.record);
      }
      deleted = changes.size() - records.size();
      return records;
    });
    for (const auto& [id, record] : live_) {
      const auto found = store.Find(kRoom, id);
      take(found, 1, [](const std::optional<AnchorRecord>& one) {
        return one ? std::vector{*one} : std::vector<AnchorRecord>();
      });
    }
    return complete && deleted == 12;
  }

  enum class Finding { kHarmless, kRefusedToOpen, kReadsRefused, kFoundByCheck };

  Finding Examine(const std::vector<std::uint8_t>& bytes) {
    const fs::path file = folder_.path() / "damaged.db";
    for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(file.string() + suffix);
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
    bool reads_right = false;
    {
      auto store = OpenSqliteStore(file, {.mode = OpenMode::kExisting});
      if (!store) {
        EXPECT_TRUE(kOk(store.error().code)) << ToString(store.error());
        return Finding::kRefusedToOpen;
      }
      reads_right = ReadsRight(**store);
    }
    const auto check = CheckSqliteStore(file);
    if (reads_right) {
      return !check || !check->problems.empty() ? Finding::kFoundByCheck : Finding::kHarmless;
    }
    if (check) {
      EXPECT_FALSE(check->problems.empty()) << "check calls a damaged store sound";
    }
    return Finding::kReadsRefused;
  }

  const RoomId kRoom{"room"};
  TemporaryFolder folder_;
  const fs::path sound_ = folder_.path() / "anchors.db";
  std::map<std::uint64_t, std::optional<AnchorRecord>> history_;  // by revision
  std::map<AnchorId, AnchorRecord> live_;
  std::vector<std::uint8_t> bytes_;
};

TEST_F(Damage, TheSoundStoreReadsRight) {
  EXPECT_EQ(Examine(bytes_), Finding::kHarmless);
  const auto check = CheckSqliteStore(sound_);
  EXPECT_THAT(check->problems, testing::IsEmpty());
  EXPECT_EQ(check->revision, history_.size());
  EXPECT_EQ(check->anchors, live_.size());
  EXPECT_EQ(check->deleted, 12u);
  EXPECT_EQ(check->superseded, history_.size() - live_.size() - 12);
}

TEST_F(Damage, AFlippedByteNeverServesAWrongRecord) {
  std::mt19937_64 random(3);
  std::map<Finding, int> findings;
  for (int trial = 0; trial < 400 && !HasFailure(); ++trial) {
    auto bytes = bytes_;
    const std::size_t at = trial < 100 ? static_cast<std::size_t>(trial) : random() % bytes.size();
    bytes[at] ^= static_cast<std::uint8_t>(1 + random() % 255);
    SCOPED_TRACE(fmt::format("byte {}: {:#x} became {:#x}", at, bytes_[at], bytes[at]));
    ++findings[Examine(bytes)];
  }
  EXPECT_GT(findings[Finding::kReadsRefused], 0);
  EXPECT_GT(findings[Finding::kRefusedToOpen], 0);
}

TEST_F(Damage, AZeroedOrExchangedPageNeverServesAWrongRecord) {
  constexpr std::size_t kPage = 4096;
  for (std::size_t page = 0; (page + 1) * kPage <= bytes_.size() && !HasFailure(); ++page) {
    SCOPED_TRACE(page);
    auto bytes = bytes_;
    std::fill_n(bytes.begin() + page * kPage, kPage, 0);
    EXPECT_NE(Examine(bytes), Finding::kHarmless);
    bytes = bytes_;
    const std::size_t other = (page + 1) % (bytes.size() / kPage);
    std::swap_ranges(bytes.begin() + page * kPage, bytes.begin() + (page + 1) * kPage,
                     bytes.begin() + other * kPage);
    EXPECT_NE(Examine(bytes), Finding::kHarmless);
  }
}

TEST_F(Damage, ATruncatedFileIsRefused) {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 30 && !HasFailure(); ++trial) {
    auto bytes = bytes_;
    bytes.resize(random() % bytes.size());
    SCOPED_TRACE(bytes.size());
    EXPECT_NE(Examine(bytes), Finding::kHarmless);
  }
}

TEST_F(Damage, AWriteOnADamagedAnchorIsRefused) {
  // The payload of anchor 3 as the file has it, one letter changed.
  const std::string wanted = "payload 3 ";
  const auto at = std::search(bytes_.begin(), bytes_.end(), wanted.begin(), wanted.end());
  ASSERT_NE(at, bytes_.end());
  auto bytes = bytes_;
  bytes[static_cast<std::size_t>(at - bytes_.begin())] = 'q';
  const fs::path file = folder_.path() / "one.db";
  ASSERT_TRUE(StoreFileAtomically(file, std::span<const std::uint8_t>(bytes)));
  auto store = OpenSqliteStore(file);
  ASSERT_TRUE(store);
  const AnchorRecord record = live_.at(IdOf(3));
  for (const auto& outcome : {(*store)->Create(record), (*store)->Update(record, record.revision),
                              (*store)->Delete(record.room, record.id, record.revision)}) {
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(outcome.error().message, testing::HasSubstr("checksum"));
  }
  Applied((*store)->Create(MakeAnchor(100)));  // the others go on
}

}  // namespace
}  // namespace waymark::content

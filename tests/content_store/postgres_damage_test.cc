// SPDX-License-Identifier: Apache-2.0
// Damage in PostgreSQL, by rows and by bytes of its files: never a wrong record, and `check` finds
// what reading does not.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <random>

#include "content_store/store_check.h"
#include "mapping/base/file.h"
#include "tests/content_store/anchor_fixtures.h"
#include "tests/content_store/postgres_server.h"

namespace waymark::content {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::uint64_t kAnchors = 60;  // some pages full

class PostgresDamage : public testing::Test {
 protected:
  void SetUp() override {
    if (!SharedPostgres()) GTEST_SKIP() << SharedPostgres().error().message;
    server_ = SharedPostgres()->get();
    Refill();
  }
  void TearDown() override {
    if (server_ != nullptr) Change("ALTER ROLE waymark RESET ignore_checksum_failure");
  }

  /// Revision n + 1 creates anchor n; then every fourth is updated.
  void Refill() {
    store_.reset();
    truth_.clear();
    Change("DROP SCHEMA IF EXISTS waymark CASCADE");
    Open();
    std::vector<AnchorRecord> records;
    for (std::uint64_t n = 0; n < kAnchors; ++n) records.push_back(MakeAnchor(n));
    std::vector<AnchorRecord> changed;
    for (const auto& outcome : store_->CreateMany(records)) {
      const AnchorRecord record = Applied(outcome);
      truth_.emplace(record.revision, record);
      if (record.revision % 4 == 0) changed.push_back(record);
    }
    for (AnchorRecord& record : changed) record.payload += " again";
    for (const auto& outcome : store_->UpdateMany(changed)) {
      truth_.emplace(Applied(outcome).revision, Applied(outcome));
    }
  }
  void Open() {
    auto store = OpenPostgresStore(server_->Uri());
    ASSERT_TRUE(store) << ToString(store.error());
    store_ = *std::move(store);
  }
  void Change(const std::string& statements) {
    const auto done = server_->Execute(statements);
    ASSERT_TRUE(done) << ToString(done.error());
  }
  std::vector<std::string> Problems() {
    const auto check = CheckStore(server_->Uri());
    return check ? check->problems : std::vector<std::string>{ToString(check.error())};
  }

  /// Reads all in every way; a failure must be Corrupt, and what is served must be true.
  void ExpectNothingWrong() {
    const auto look = [&](const auto& result, const auto& records) {
      if (!result) {
        EXPECT_EQ(result.error().code, ErrorCode::kCorrupt) << result.error().message;
        return;
      }
      for (const AnchorRecord& record : records(*result)) {
        const auto known = truth_.find(record.revision);
        ASSERT_NE(known, truth_.end()) << "an invented revision was served";
        ASSERT_TRUE(SameAnchor(record, known->second)) << "a wrong record was served";
      }
    };
    using Records = std::vector<AnchorRecord>;
    for (std::uint64_t n = 0; n < kAnchors; ++n) {
      look(store_->Find(kRoom, IdOf(n)), [](const std::optional<AnchorRecord>& found) {
        return found ? Records{*found} : Records{};
      });
    }
    look(store_->LoadRoom(kRoom), [](const RoomSnapshot& room) { return room.anchors; });
    look(store_->FindNear(kRoom, PlaceAt(47.35, 8.55), 20'000, 1000),
         [](const Records& records) { return records; });
    look(store_->LoadChanges(0, 1000), [](const std::vector<AnchorChange>& changes) {
      Records records;
      for (const AnchorChange& change : changes) records.push_back(*change.record);
      return records;
    });
  }
  void ExpectCorrupt(std::uint64_t n) {
    const auto found = store_->Find(kRoom, IdOf(n));
    ASSERT_FALSE(found) << "anchor " << n;
    EXPECT_EQ(found.error().code, ErrorCode::kCorrupt) << found.error().message;
  }

  const RoomId kRoom{"room"};
  PostgresServer* server_ = nullptr;
  std::unique_ptr<AnchorStore> store_;
  std::map<std::uint64_t, AnchorRecord> truth_;  // by revision
};

TEST_F(PostgresDamage, AFlippedByteOfAStateIsNeverServedAndFoundByCheck) {
  std::mt19937_64 random(11);
  const auto size = server_->Ask("SELECT length(state) FROM waymark.states WHERE revision = 3");
  ASSERT_TRUE(size) << ToString(size.error());
  int trials = 0;
  for (int at = 0; at < std::stoi(*size) && !HasFailure(); at += 8, ++trials) {
    const std::string flip = fmt::format(
        "UPDATE waymark.states SET state = set_byte(state, {0}, get_byte(state, {0}) # {1}) WHERE "
        "revision = 3",
        at, 1 + random() % 255);
    SCOPED_TRACE(flip);
    Change(flip);
    ExpectCorrupt(2);
    EXPECT_FALSE(store_->LoadRoom(kRoom));
    EXPECT_FALSE(store_->Update(MakeAnchor(2), 3)) << "nor is it built upon";
    EXPECT_TRUE(store_->Find(kRoom, IdOf(1))) << "the others go on";
    if (trials % 16 == 0) {
      EXPECT_THAT(Problems(), Contains(HasSubstr("revision 3: expected checksum")));
    }
    Change(flip);  // back again
  }
  EXPECT_GT(trials, 30);
  EXPECT_THAT(Problems(), IsEmpty());
  ExpectNothingWrong();
}

TEST_F(PostgresDamage, CheckFindsEveryColumnThatDisagrees) {
  const std::pair<const char*, const char*> kDamages[] = {
      {"UPDATE waymark.states SET checksum = checksum + 1 WHERE revision = 3", "checksum"},
      {"UPDATE waymark.states SET room = 'other' WHERE revision = 3", "its keys and its state"},
      {"UPDATE waymark.states SET id = 'other' WHERE revision = 3", "its keys and its state"},
      {"UPDATE waymark.states SET previous = 3 WHERE revision = 3", "predecessor is not older"},
      {"UPDATE waymark.states SET revision = 1000 WHERE revision = 3", "its keys and its state"},
      {"DELETE FROM waymark.states WHERE revision = 3", "expected revision 3"},
      {"UPDATE waymark.places SET cell = cell + 4 WHERE revision = 3", "cell of its place"},
      {"UPDATE waymark.places SET changed = changed + 1 WHERE revision = 3", "the times"},
      {"UPDATE waymark.places SET expires = 5 WHERE revision = 3", "the times"},
      {"UPDATE waymark.places SET is_public = NOT is_public WHERE revision = 3", "visibility"},
      {"UPDATE waymark.places SET revision = 2 WHERE revision = 3", "its keys and its state"},
      {"UPDATE waymark.places SET revision = 1000 WHERE revision = 3", "which is not there"},
      {"DELETE FROM waymark.places WHERE revision = 3", "misses 1 states"},
      {"UPDATE waymark.usage SET anchors = anchors + 1 WHERE owner = 'device-2'", "usage of owner"},
      {"DELETE FROM waymark.usage WHERE owner = 'device-2'", "usage of owner"},
      {"INSERT INTO waymark.facts VALUES ('compacted_rows', 1)", "expected 1 states"},
  };
  for (const auto& [damage, finding] : kDamages) {
    SCOPED_TRACE(damage);
    Refill();
    ASSERT_THAT(Problems(), IsEmpty());
    Change(damage);
    EXPECT_THAT(Problems(), Contains(HasSubstr(finding)));
    ExpectNothingWrong();
  }
}

/// Puts a letter of a payload wrong in the file of a table.
void SpoilPayload(const fs::path& file, const std::string& payload) {
  auto bytes = LoadFile(file).value();
  const auto at = std::search(bytes.begin(), bytes.end(), payload.begin(), payload.end());
  ASSERT_NE(at, bytes.end());
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary)
      .seekp(at - bytes.begin())
      .put('q');
}

TEST_F(PostgresDamage, AFlippedByteOnDiskIsFoundWithAndWithoutTheServersOwnChecksums) {
  const auto table = server_->Ask("SELECT pg_relation_filepath('waymark.states')");
  ASSERT_TRUE(table);
  ASSERT_TRUE(server_->ChangeFiles(
      [&](const fs::path& data) { SpoilPayload(data / *table, "payload 2 "); }));
  Open();
  ExpectCorrupt(2);
  EXPECT_TRUE(store_->Find(kRoom, IdOf(kAnchors - 2))) << "on another page";
  EXPECT_THAT(Problems(), Contains(HasSubstr("invalid page")));
  ExpectNothingWrong();
  // As on a server that was made without checksums of pages.
  Change("ALTER ROLE waymark SET ignore_checksum_failure = on");
  Open();
  ExpectCorrupt(2);
  EXPECT_TRUE(store_->Find(kRoom, IdOf(1))) << "on the same page";
  EXPECT_THAT(Problems(), Contains(HasSubstr("expected checksum")));
  ExpectNothingWrong();
}

TEST_F(PostgresDamage, AFlippedByteAnywhereInTableOrIndexServesNoWrongRecord) {
  std::mt19937_64 random(12);
  for (const char* file : {"states", "states_pkey", "places", "places_pkey", "places_by_cell"}) {
    SCOPED_TRACE(file);
    Refill();
    const auto path = server_->Ask(fmt::format("SELECT pg_relation_filepath('waymark.{}')", file));
    ASSERT_TRUE(path);
    ASSERT_TRUE(server_->ChangeFiles([&](const fs::path& data) {
      std::fstream bytes(data / *path, std::ios::in | std::ios::out | std::ios::binary);
      const auto size = fs::file_size(data / *path);
      for (int i = 0; i < 3; ++i) {
        const auto at = static_cast<std::streamoff>(random() % size);
        bytes.seekg(at);
        const int byte = bytes.get();
        bytes.seekp(at).put(static_cast<char>(byte ^ static_cast<int>(1 + random() % 255)));
      }
    }));
    Open();
    ExpectNothingWrong();
    EXPECT_THAT(Problems(), testing::Not(IsEmpty()));
  }
}

}  // namespace
}  // namespace waymark::content

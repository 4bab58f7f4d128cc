// SPDX-License-Identifier: Apache-2.0
// Stores in PostgreSQL that earlier versions of this program made. The first was version 2.
#include <gmock/gmock.h>

#include <array>
#include <optional>
#include <thread>

#include "content_store/anchor_rules.h"
#include "content_store/internal/anchor_tables.h"
#include "content_store/store_admin.h"
#include "content_store/store_check.h"
#include "tests/content_store/anchor_fixtures.h"
#include "tests/content_store/postgres_server.h"

namespace waymark::content {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// As version 2 made it: what is written here never changes.
constexpr const char* kVersion2 = R"(
CREATE SCHEMA waymark;
CREATE TABLE waymark.facts (name text COLLATE "C" PRIMARY KEY, value bigint NOT NULL);
CREATE TABLE waymark.states (revision bigint PRIMARY KEY, previous bigint NOT NULL, room text
COLLATE "C" NOT NULL, id text COLLATE "C" NOT NULL, state bytea NOT NULL, checksum bigint NOT NULL);
CREATE INDEX states_by_room ON waymark.states (room, revision);
CREATE TABLE waymark.places (room text COLLATE "C" NOT NULL, id text COLLATE "C" NOT NULL, revision
bigint NOT NULL, cell bigint, changed bigint, expires bigint, is_public boolean NOT NULL,
PRIMARY KEY (room, id));
CREATE INDEX places_by_cell ON waymark.places (room, cell, revision) WHERE cell IS NOT NULL;
CREATE INDEX places_by_change ON waymark.places (room, changed, revision) WHERE changed IS NOT NULL;
CREATE INDEX places_by_expiry ON waymark.places (expires) WHERE expires IS NOT NULL;
CREATE INDEX public_places_by_cell ON waymark.places (cell, revision) WHERE is_public;
CREATE TABLE waymark.usage (room text COLLATE "C" NOT NULL, owner text COLLATE "C" NOT NULL, anchors
bigint NOT NULL, bytes bigint NOT NULL, PRIMARY KEY (room, owner));
INSERT INTO waymark.facts VALUES ('schema_version', 2);
)";

/// Columns, indexes and version of what is there, in words.
constexpr const char* kDescribe = R"(
SELECT string_agg(line, chr(10) ORDER BY line) FROM (
SELECT concat_ws(' ', table_name, column_name, data_type, collation_name, is_nullable) AS line
FROM information_schema.columns WHERE table_schema = 'waymark'
UNION ALL SELECT indexdef FROM pg_indexes WHERE schemaname = 'waymark'
UNION ALL SELECT name || value FROM waymark.facts WHERE name = 'schema_version') AS lines)";

std::string Hex(const std::string& bytes) {
  return fmt::format("{:02x}",
                     fmt::join(std::vector<std::uint8_t>(bytes.begin(), bytes.end()), ""));
}

class PostgresMigration : public testing::Test {
 protected:
  void SetUp() override {
    if (!SharedPostgres()) GTEST_SKIP() << SharedPostgres().error().message;
    server_ = SharedPostgres()->get();
    Run("DROP SCHEMA IF EXISTS waymark CASCADE");
  }
  void Run(const std::string& statements) {
    const auto done = server_->Execute(statements);
    ASSERT_TRUE(done) << ToString(done.error());
  }
  std::string Describe() { return server_->Ask(kDescribe).value(); }

  /// Anchors as version 2 wrote them: all created, every third updated, every fifth deleted.
  void FillVersion2() {
    std::string statements = kVersion2;
    std::uint64_t revision = 0;
    for (std::uint64_t n = 0; n < 40; ++n) {
      internal::AnchorState state{.record = MakeAnchor(n),
                                  .creation = ContentFingerprint(MakeAnchor(n))};
      std::uint64_t previous = 0;
      const auto append = [&] {
        state.record.revision = ++revision;
        const internal::LogRow row = internal::ToLogRow(state, std::exchange(previous, revision));
        statements +=
            fmt::format("INSERT INTO waymark.states VALUES ({}, {}, '{}', '{}', '\\x{}', {});",
                        row.revision, row.previous, row.room, row.id, Hex(row.state), row.checksum);
      };
      append();
      if (n % 3 == 0) {
        state.record.payload += " again";
        append();
      }
      if (n % 5 == 0) {
        state = {.record = {.id = state.record.id, .room = state.record.room}, .creation = {}};
        state.is_deleted = true;
        append();
      }
      statements += AddPlace(state);
    }
    Run(statements);
  }
  static std::string AddPlace(const internal::AnchorState& state) {
    const internal::PlaceRow place = internal::ToPlaceRow(state);
    const auto text = [](const std::optional<std::int64_t>& value) {
      return value ? std::to_string(*value) : "NULL";
    };
    std::string statements =
        fmt::format("INSERT INTO waymark.places VALUES ('{}', '{}', {}, {}, {}, {}, {});",
                    place.key.room.text(), place.key.id.text(), place.revision, text(place.cell),
                    text(place.changed), text(place.expires), place.is_public);
    if (state.is_deleted) return statements;
    return statements + fmt::format("INSERT INTO waymark.usage VALUES ('{}', '{}', 1, {});",
                                    state.record.room.text(), state.record.owner,
                                    state.record.payload.size());
  }

  PostgresServer* server_ = nullptr;
};

TEST_F(PostgresMigration, Version2KeepsAllAndIsSoundAfterwards) {
  FillVersion2();
  auto store = OpenPostgresStore(server_->Uri());
  ASSERT_TRUE(store) << ToString(store.error());
  for (std::uint64_t n = 0; n < 40; ++n) {
    AnchorRecord record = MakeAnchor(n);
    const auto found = (*store)->Find(record.room, record.id);
    ASSERT_TRUE(found) << ToString(found.error());
    ASSERT_EQ(found->has_value(), n % 5 != 0);
    if (!*found) continue;
    if (n % 3 == 0) record.payload += " again";
    EXPECT_TRUE(SameAnchor(**found, record));
  }
  EXPECT_EQ((*store)->LoadChanges(0, 1000)->size(), 40u + 14 + 8);
  EXPECT_EQ((*store)->Query({.room = RoomId("room"), .limit = 1000})->anchors.size(), 32u);
  EXPECT_EQ(Applied((*store)->Create(MakeAnchor(1))).revision, 4u) << "a retry is recognised";
  EXPECT_FALSE(Conflict((*store)->Create(MakeAnchor(5))).current) << "a spent id stays spent";
  Applied((*store)->Create(MakeAnchor(100)));
  const auto check = CheckStore(server_->Uri());
  ASSERT_TRUE(check) << ToString(check.error());
  EXPECT_THAT(check->problems, IsEmpty());
  EXPECT_EQ(check->anchors, 33u);
  EXPECT_EQ(check->deleted, 8u);
}

TEST_F(PostgresMigration, WhatWasUpgradedIsWhatIsMadeToday) {
  FillVersion2();
  ASSERT_TRUE(OpenPostgresStore(server_->Uri()));
  const std::string upgraded = Describe();
  EXPECT_FALSE(MigrateStore(server_->Uri()).value()) << "it is of today";
  Run("DROP SCHEMA waymark CASCADE");
  ASSERT_TRUE(OpenPostgresStore(server_->Uri()));
  EXPECT_EQ(Describe(), upgraded);
}

TEST_F(PostgresMigration, ANewerOrAnUnknownVersionIsRefusedAndLeftAlone) {
  FillVersion2();
  for (const int version : {1, 3, 9}) {
    Run(fmt::format("UPDATE waymark.facts SET value = {} WHERE name = 'schema_version'", version));
    const std::string before = Describe();
    const auto refused = OpenPostgresStore(server_->Uri());
    ASSERT_FALSE(refused) << version;
    EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(refused.error().message, HasSubstr(fmt::format("found {}", version)));
    EXPECT_EQ(Describe(), before);
  }
  Run("UPDATE waymark.facts SET value = 2 WHERE name = 'schema_version'");
  EXPECT_TRUE(OpenPostgresStore(server_->Uri()));
}

TEST_F(PostgresMigration, OfManyWhoMakeTheStoreAtOnceAllFindOne) {
  std::array<std::optional<Result<std::unique_ptr<AnchorStore>>>, 4> stores;
  {
    std::vector<std::jthread> threads;
    for (auto& store : stores) {
      threads.emplace_back([&] { store.emplace(OpenPostgresStore(server_->Uri())); });
    }
  }
  for (std::uint64_t n = 0; n < stores.size(); ++n) {
    const auto& store = *stores[n];
    ASSERT_TRUE(store) << ToString(store.error());
    EXPECT_EQ(Applied((*store)->Create(MakeAnchor(n))).revision, n + 1);
  }
  EXPECT_THAT(CheckStore(server_->Uri())->problems, IsEmpty());
}

}  // namespace
}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
// Inner pages as SQLite wrote them lead to the leaf that holds a key; other bytes lead nowhere.
#include "content_store/internal/sqlite_page.h"

#include <gmock/gmock.h>
#include <sqlite3.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <vector>

#include "tests/support/temporary_root.h"

namespace waymark::content::internal {
namespace {

using Bytes = std::vector<std::uint8_t>;
using IndexKey = SqliteInnerPage::IndexKey;

constexpr std::size_t kPage = 4096;
constexpr int kRows = 30'000;

/// A database with a table of rows and an index of two columns, as the store has them.
class Pages : public testing::Test {
 protected:
  void SetUp() override {
    const auto path =
        waymark::support::TemporaryRoot() / ("waymark_pages_" + std::to_string(::getpid()) + ".db");
    std::filesystem::remove(path);
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
    const auto run = [&](const std::string& statement) {
      ASSERT_EQ(sqlite3_exec(database, statement.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
          << sqlite3_errmsg(database);
    };
    run("PRAGMA page_size = 4096");
    run("CREATE TABLE t (n INTEGER PRIMARY KEY, room TEXT, cell INTEGER, more BLOB)");
    run("CREATE INDEX i ON t (room, cell, n)");
    run("WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c WHERE x < " +
        std::to_string(kRows) +
        ") INSERT INTO t SELECT x, 'room ' || (x % 7), (x * 7919 % 30011 - 15000) * (x % 3) * "
        "100000007, zeroblob(300) FROM c");
    sqlite3_close(database);
    std::ifstream file(path, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(file), {});
    std::filesystem::remove(path);
  }

  std::span<const std::uint8_t> At(std::uint32_t number) const {
    return std::span(bytes_).subspan((number - 1) * kPage, kPage);
  }
  /// All inner pages of one kind.
  void ForEachInner(bool is_index, const std::function<void(const SqliteInnerPage&)>& look) const {
    for (std::uint32_t number = 2; number <= bytes_.size() / kPage; ++number) {
      if (At(number)[0] != (is_index ? 2 : 5)) continue;
      const auto inner = SqliteInnerPage::Parse(At(number));
      ASSERT_TRUE(inner);
      look(*inner);
    }
  }
  /// The first rowid of a table's leaf.
  std::int64_t FirstRowid(std::uint32_t leaf) const {
    const auto page = At(leaf);
    EXPECT_EQ(page[0], 13) << "a leaf of a table";
    const std::size_t cell = std::size_t{page[8]} << 8 | page[9];
    std::size_t at = cell;
    while ((page[at] & 0x80) != 0) ++at;  // size of the row
    std::int64_t rowid = 0;
    do {
      rowid = rowid << 7 | (page[++at] & 0x7f);
    } while ((page[at] & 0x80) != 0);
    return rowid;
  }

  Bytes bytes_;
};

TEST_F(Pages, ATablesKeysTellItsChildrenApart) {
  std::size_t leaves = 0;
  ForEachInner(false, [&](const SqliteInnerPage& inner) {
    std::int64_t before = -1;
    for (std::size_t i = 0; i <= inner.key_count(); ++i) {
      if (At(inner.Child(i))[0] != 13) continue;  // a root above inner pages
      ++leaves;
      const std::int64_t first = FirstRowid(inner.Child(i));
      EXPECT_GT(first, before);
      if (i == inner.key_count()) continue;
      before = *inner.Rowid(i);
      EXPECT_LE(first, before);
      EXPECT_FALSE(inner.Key(i)) << "no index";
    }
  });
  EXPECT_GT(leaves, std::size_t{kRows} / 13);
}

TEST_F(Pages, AnIndexsKeysAreInOrderAndOfItsRows) {
  std::size_t keys = 0;
  ForEachInner(true, [&](const SqliteInnerPage& inner) {
    std::optional<std::pair<std::string, std::int64_t>> before;
    for (std::size_t i = 0; i < inner.key_count(); ++i, ++keys) {
      const auto key = inner.Key(i);
      ASSERT_TRUE(key);
      const std::pair now{std::string(key->text), key->number};
      EXPECT_TRUE(now.first.starts_with("room "));
      EXPECT_EQ(now.second % 100000007, 0);
      if (before) {
        EXPECT_GE(now, *before);
      }
      before = now;
      EXPECT_FALSE(inner.Rowid(i)) << "no table";
    }
  });
  EXPECT_GT(keys, 100u);
}

TEST_F(Pages, OtherBytesAreReadWithinTheirBounds) {
  std::mt19937 random(1);
  for (const bool is_index : {false, true}) {
    std::optional<Bytes> some;
    for (std::uint32_t number = 2; !some; ++number) {
      if (At(number)[0] == (is_index ? 2 : 5)) some.emplace(At(number).begin(), At(number).end());
    }
    for (int trial = 0; trial < 20'000; ++trial) {
      Bytes page = *some;
      for (int flips = 0; flips < 8; ++flips) {
        page[random() % (flips < 4 ? 64 : page.size())] = static_cast<std::uint8_t>(random());
      }
      if (trial % 3 == 0) page.resize(random() % page.size());
      const auto inner = SqliteInnerPage::Parse(page);
      if (!inner) continue;
      for (std::size_t i = 0; i < std::min<std::size_t>(inner->key_count(), 50); ++i) {
        (void)inner->Child(i);
        (void)inner->Rowid(i);
        (void)inner->Key(i);
      }
      (void)inner->Child(inner->key_count());
    }
  }
  EXPECT_FALSE(SqliteInnerPage::Parse(Bytes{}));
  EXPECT_FALSE(SqliteInnerPage::Parse(Bytes(kPage, 0)));
}

}  // namespace
}  // namespace waymark::content::internal

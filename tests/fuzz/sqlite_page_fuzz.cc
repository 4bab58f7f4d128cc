// SPDX-License-Identifier: Apache-2.0
#include <sqlite3.h>

#include "content_store/internal/sqlite_page.h"
#include "mapping/base/check.h"
#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {

using content::internal::SqliteInnerPage;

/// The inner pages of a table and of an index as SQLite itself writes them.
std::vector<Bytes> Seeds() {
  constexpr std::size_t kPage_bytes = 512;
  sqlite3* database = nullptr;
  CHECK(sqlite3_open(":memory:", &database) == SQLITE_OK);
  const char* const statements =
      "PRAGMA page_size = 512; CREATE TABLE states (revision INTEGER PRIMARY KEY, state TEXT); "
      "CREATE INDEX places ON states (state, revision); WITH RECURSIVE n(i) AS (VALUES (1) UNION "
      "ALL SELECT 3 * i FROM n WHERE i < 1000000000000000000) INSERT INTO states SELECT i, "
      "substr('a room with a rather long name, so that pages have few keys', 1, 20 + i % 40) FROM "
      "n; INSERT INTO states SELECT revision - 1, state || revision FROM states WHERE revision > 1";
  CHECK(sqlite3_exec(database, statements, nullptr, nullptr, nullptr) == SQLITE_OK, "{}",
        sqlite3_errmsg(database));
  sqlite3_int64 size = 0;
  unsigned char* const file = sqlite3_serialize(database, "main", &size, 0);
  CHECK(file != nullptr);
  std::vector<Bytes> seeds;
  for (std::size_t at = kPage_bytes; at < static_cast<std::size_t>(size); at += kPage_bytes) {
    Bytes page(file + at, file + at + kPage_bytes);
    if (SqliteInnerPage::Parse(page)) seeds.push_back(std::move(page));
  }
  sqlite3_free(file);
  sqlite3_close(database);
  CHECK(seeds.size() >= 2, "expected inner pages of both kinds, found {}", seeds.size());
  return seeds;
}

void TryOne(std::span<const std::uint8_t> bytes) {
  const auto page = SqliteInnerPage::Parse(bytes);
  if (!page) return;
  const auto* const begin = reinterpret_cast<const char*>(bytes.data());
  (void)page->Child(page->key_count());
  for (std::size_t i = 0; i < page->key_count(); ++i) {
    (void)page->Child(i);
    const auto rowid = page->Rowid(i);
    const auto key = page->Key(i);
    CHECK(!rowid || !key, "a page is of a table or of an index");
    if (!key || key->text.empty()) continue;
    const bool is_inside =
        key->text.data() >= begin && key->text.data() + key->text.size() <= begin + bytes.size();
    CHECK(is_inside, "a key beyond its page");
  }
}

}  // namespace waymark::fuzz

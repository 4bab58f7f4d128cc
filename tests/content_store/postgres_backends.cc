// SPDX-License-Identifier: Apache-2.0
// The common suites on PostgreSQL.
#include "tests/content_store/anchor_stores.h"
#include "tests/content_store/postgres_server.h"

namespace waymark::content {
namespace {

/// The store of a folder; a folder not seen before begins with an empty one.
Result<std::unique_ptr<AnchorStore>> OpenPostgres(const std::filesystem::path& folder,
                                                  const StoreOptions& options) {
  static std::filesystem::path latest;
  if (!SharedPostgres()) return SharedPostgres().error();
  const PostgresServer& server = **SharedPostgres();
  if (folder != latest) WAYMARK_TRY(server.Execute("DROP SCHEMA IF EXISTS waymark CASCADE"));
  latest = folder;
  return OpenPostgresStore(server.Uri(), options);
}

const auto kBackends = testing::Values(Backend{"Postgres", OpenPostgres, true});

INSTANTIATE_TEST_SUITE_P(All, AnchorStores, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorLimits, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorNeighbours, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorThreads, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorQueries, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorChanges, kBackends, BackendName);

}  // namespace
}  // namespace waymark::content

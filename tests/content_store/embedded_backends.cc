// SPDX-License-Identifier: Apache-2.0
// The common suites on the stores that need no server.
#include "tests/content_store/anchor_stores.h"
#include "tests/support/memory_anchor_store.h"

namespace waymark::content {
namespace {

Result<std::unique_ptr<AnchorStore>> OpenMemory(const std::filesystem::path&, const StoreOptions&) {
  return {std::make_unique<support::MemoryAnchorStore>()};
}

Result<std::unique_ptr<AnchorStore>> OpenSqlite(const std::filesystem::path& folder,
                                                const StoreOptions& options) {
  return OpenSqliteStore(folder / "anchors.db", options);
}

const auto kBackends =
    testing::Values(Backend{"Memory", OpenMemory, false}, Backend{"Sqlite", OpenSqlite, true});

INSTANTIATE_TEST_SUITE_P(All, AnchorStores, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorLimits, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorNeighbours, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorThreads, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorQueries, kBackends, BackendName);
INSTANTIATE_TEST_SUITE_P(All, AnchorChanges, kBackends, BackendName);

}  // namespace
}  // namespace waymark::content

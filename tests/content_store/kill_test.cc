// SPDX-License-Identifier: Apache-2.0
// A writing process is killed at arbitrary moments; what it acknowledged is there.
#include <gmock/gmock.h>

#include "content_store/store_check.h"
#include "tests/content_store/killed_writer.h"

namespace waymark::content {
namespace {

using testing::IsEmpty;

TEST(KilledWriter, LeavesEveryAcknowledgedWriteAndNothingTorn) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "anchors.db";
  AcknowledgedWrites acknowledged;
  const int kills = KillWriters([&] { return OpenSqliteStore(file); }, 60, acknowledged);
  const auto check = CheckSqliteStore(file);
  ASSERT_TRUE(check) << ToString(check.error());
  EXPECT_THAT(check->problems, IsEmpty());
  EXPECT_GE(check->revision, acknowledged.size());
  fmt::print("{} kills, {} acknowledged writes: {} lost, {} torn; {} more had committed unheard\n",
             kills, acknowledged.size(), acknowledged.lost(), acknowledged.torn(),
             check->revision - acknowledged.size());
}

}  // namespace
}  // namespace waymark::content

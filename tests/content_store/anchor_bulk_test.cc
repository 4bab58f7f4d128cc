// SPDX-License-Identifier: Apache-2.0
// What every anchor store promises about many writes at once.
#include <gmock/gmock.h>

#include "tests/content_store/anchor_stores.h"

namespace waymark::content {
namespace {

using testing::IsEmpty;

TEST_P(AnchorChanges, ABulkLoadAnswersForEach) {
  Applied(store_->Create(MakeAnchor(3)));
  std::vector<AnchorRecord> records;
  for (std::uint64_t n = 0; n < 1500; ++n) records.push_back(MakeAnchor(n));
  records[7].epoch = 0;             // invalid
  records[9] = records[8];          // the same one twice
  records[11].id = records[10].id;  // another one under its id
  const auto outcomes = store_->CreateMany(records);
  ASSERT_EQ(outcomes.size(), records.size());
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (i == 7) {
      EXPECT_FALSE(outcomes[i]);
    } else if (i == 11) {
      EXPECT_TRUE(Conflict(outcomes[i]).current);
    } else {
      EXPECT_EQ(Applied(outcomes[i]).id, records[i].id);
    }
  }
  EXPECT_EQ(store_->LoadRoom(kRoom)->anchors.size(), 1497u);
  EXPECT_THAT(store_->CreateMany({}), IsEmpty());
}

TEST_P(AnchorChanges, ABulkUpdateExpectsTheRevisionsOfItsRecords) {
  std::vector<AnchorRecord> records;
  for (std::uint64_t n = 0; n < 1100; ++n) records.push_back(MakeAnchor(n));
  const auto created = store_->CreateMany(records);
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i] = Applied(created[i]);
    records[i].epoch = 77;
  }
  records[3].revision = 2;  // of another one
  records[5].epoch = 0;     // invalid
  const auto outcomes = store_->UpdateMany(records);
  ASSERT_EQ(outcomes.size(), records.size());
  EXPECT_EQ(Conflict(outcomes[3]).current->epoch, MakeAnchor(3).epoch);
  EXPECT_FALSE(outcomes[5]);
  for (const std::size_t i : {0u, 4u, 6u, 1099u}) {
    EXPECT_GT(Applied(outcomes[i]).revision, 1100u);
    EXPECT_TRUE(SameAnchor(FindAnchor(records[i]), records[i]));
  }
  EXPECT_THAT(store_->UpdateMany({}), IsEmpty());
}

}  // namespace
}  // namespace waymark::content

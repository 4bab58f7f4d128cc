// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <vector>

#include "content_store/anchor_store.h"
#include "tests/content_store/anchor_fixtures.h"
#include "tests/support/memory_anchor_store.h"

namespace waymark::content {

enum class Backend { kMemory, kSqlite };

/// A fresh store of either kind.
class AnchorStores : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    if (GetParam() == Backend::kMemory) {
      store_ = std::make_unique<support::MemoryAnchorStore>();
      return;
    }
    auto store = OpenSqliteStore(folder_.path() / "anchors.db");
    ASSERT_TRUE(store) << ToString(store.error());
    store_ = *std::move(store);
  }

  AnchorRecord FindAnchor(const AnchorRecord& wanted) {
    const auto found = store_->Find(wanted.room, wanted.id);
    if (found && *found) return **found;
    ADD_FAILURE() << (found ? "not there" : ToString(found.error()));
    return MakeAnchor(0);
  }
  std::vector<std::string> Near(const GeoPoint& centre, double radius_m, std::size_t limit = 100) {
    const auto found = store_->FindNear(kRoom, centre, radius_m, limit);
    if (!found) return {ToString(found.error())};
    std::vector<std::string> ids;
    for (const AnchorRecord& record : *found) ids.push_back(record.id.text());
    return ids;
  }
  void ExpectInvalid(const AnchorRecord& record, const std::string& field) {
    const auto outcome = store_->Create(record);
    ASSERT_FALSE(outcome) << field;
    EXPECT_EQ(outcome.error().code, ErrorCode::kInvalidArgument) << field;
    EXPECT_THAT(outcome.error().message, testing::HasSubstr(field));
    EXPECT_FALSE(store_->Update(record, 1));
  }

  const RoomId kRoom{"room"};
  TemporaryFolder folder_;
  std::unique_ptr<AnchorStore> store_;
};

inline std::string BackendName(const testing::TestParamInfo<Backend>& backend) {
  return backend.param == Backend::kMemory ? "Memory" : "Sqlite";
}

}  // namespace waymark::content

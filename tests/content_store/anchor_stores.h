// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "content_store/anchor_store.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content {

/// A kind of store that the common suites run on.
struct Backend {
  std::string name;
  /// Opens the store that is wholly this folder's; the same one when asked again.
  std::function<Result<std::unique_ptr<AnchorStore>>(const std::filesystem::path& folder,
                                                     const StoreOptions& options)>
      open;
  bool keeps = true;  ///< what was written is there when it is opened again
};

inline void PrintTo(const Backend& backend, std::ostream* out) { *out << backend.name; }

inline std::string BackendName(const testing::TestParamInfo<Backend>& backend) {
  return backend.param.name;
}

/// A fresh store of each kind. The suites are instantiated in *_backends.cc.
class AnchorStores : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override { Open({}); }

  void Open(const StoreOptions& options) {
    store_.reset();
    auto store = GetParam().open(folder_.path(), options);
    if (!store && store.error().code == ErrorCode::kNotFound) {
      GTEST_SKIP() << store.error().message;
    }
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
  /// All pages of a query; a failure comes as one id that tells it.
  std::vector<AnchorRecord> QueryAll(AnchorQuery query) {
    std::vector<AnchorRecord> all;
    for (;;) {
      auto page = store_->Query(query);
      if (!page) {
        ADD_FAILURE() << ToString(page.error());
        return all;
      }
      EXPECT_LE(page->anchors.size(), query.limit);
      std::move(page->anchors.begin(), page->anchors.end(), std::back_inserter(all));
      if (!page->next) return all;
      query.after = page->next;
    }
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

// The common suites.
class AnchorLimits : public AnchorStores {};
class AnchorNeighbours : public AnchorStores {};
class AnchorThreads : public AnchorStores {};
class AnchorQueries : public AnchorStores {};
class AnchorChanges : public AnchorStores {};

}  // namespace waymark::content

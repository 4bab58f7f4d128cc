// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <cstdint>
#include <cstdio>
#include <map>

#include "content_store/anchor_store.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content {

/// A write that a store said it had done.
struct Acknowledgement {
  std::uint64_t anchor;   // the n of MakeAnchor
  std::uint64_t version;  // 0 created, above: updated; kDeleted: gone
  std::uint64_t revision;
};
inline constexpr std::uint64_t kDeleted = ~std::uint64_t{0};

/// Every field that an update sets follows from anchor and version.
inline AnchorRecord Version(std::uint64_t anchor, std::uint64_t version) {
  AnchorRecord record = MakeAnchor(anchor);
  record.owner = fmt::format("owner {}", anchor % 2);  // known from one write to the next
  record.payload = fmt::format("{} {} ", anchor, version) +
                   std::string((anchor * 31 + version * 977) % 5000, 'p');
  record.epoch = version + 1;
  return record;
}

/// What was acknowledged, against what a store has. Thread-compatible.
class AcknowledgedWrites {
 public:
  void Add(const Acknowledgement& done) {
    EXPECT_TRUE(by_revision_.emplace(done.revision, done).second) << "a revision given twice";
  }
  std::size_t size() const { return by_revision_.size(); }

  /// The changes since the last call are without a gap, none is torn, and every acknowledged write
  /// among them is what was acknowledged. Counts what is not there.
  void CompareWith(AnchorStore& store) {
    const auto changes = store.LoadChanges(seen_, 1'000'000);
    ASSERT_TRUE(changes) << ToString(changes.error());
    const std::uint64_t before = seen_;
    for (const AnchorChange& change : *changes) {
      ASSERT_EQ(change.revision, ++seen_) << "a gap in the log";
      if (change.record) ExpectWhole(*change.record);
      const auto done = by_revision_.find(change.revision);
      if (done != by_revision_.end()) ExpectSame(done->second, change);
    }
    for (auto done = by_revision_.upper_bound(before); done != by_revision_.end(); ++done) {
      if (done->first <= seen_) continue;
      ++lost_;
      ADD_FAILURE() << "revision " << done->first << " was lost";
    }
  }
  std::uint64_t seen() const { return seen_; }
  std::size_t lost() const { return lost_; }
  std::size_t torn() const { return torn_; }

 private:
  void ExpectWhole(const AnchorRecord& record) {
    unsigned long anchor = 0;
    std::sscanf(record.payload.c_str(), "%lu", &anchor);
    const bool is_whole = SameAnchor(record, Version(anchor, record.epoch - 1));
    torn_ += is_whole ? 0 : 1;
    EXPECT_TRUE(is_whole) << "a torn record at revision " << record.revision;
  }
  static void ExpectSame(const Acknowledgement& done, const AnchorChange& change) {
    EXPECT_EQ(change.id, IdOf(done.anchor));
    EXPECT_EQ(change.record.has_value(), done.version != kDeleted);
    if (change.record) {
      EXPECT_EQ(change.record->epoch, done.version + 1);
    }
  }

  std::map<std::uint64_t, Acknowledgement> by_revision_;
  std::uint64_t seen_ = 0;
  std::size_t lost_ = 0, torn_ = 0;
};

}  // namespace waymark::content

// SPDX-License-Identifier: Apache-2.0
#include "session/wire/parts.h"

#include <gmock/gmock.h>

#include <numeric>

namespace waymark::session::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes MakeFrame(std::size_t size, std::uint8_t first = 0) {
  Bytes frame(size);
  std::iota(frame.begin(), frame.end(), first);
  return frame;
}

/// What the last of these parts completes.
std::optional<Bytes> AddAll(PartCollector& collector, const std::vector<Bytes>& parts) {
  std::optional<Bytes> whole;
  for (const Bytes& part : parts) {
    EXPECT_FALSE(whole);
    auto added = collector.Add(part);
    EXPECT_TRUE(added.ok()) << ToString(added.error());
    if (added.ok()) whole = *std::move(added);
  }
  return whole;
}

TEST(Parts, ComeTogetherAgain) {
  PartCollector collector(1 << 20);
  for (const std::size_t size :
       {std::size_t{1}, kPartBytes - 1, kPartBytes, kPartBytes + 1, std::size_t{100'000}}) {
    const Bytes frame = MakeFrame(size);
    const auto parts = Cut(frame, 7);
    EXPECT_EQ(parts.size(), (size + kPartBytes - 1) / kPartBytes);
    EXPECT_TRUE(IsPart(parts.front()));
    EXPECT_EQ(AddAll(collector, parts), frame);
  }
}

TEST(Parts, TheBeginningOfAnotherEndsTheOneBefore) {
  PartCollector collector(1 << 20);
  auto given_up = Cut(MakeFrame(20'000), 1);
  given_up.resize(2);
  EXPECT_FALSE(AddAll(collector, given_up));
  const Bytes frame = MakeFrame(9'000, 3);
  EXPECT_EQ(AddAll(collector, Cut(frame, 2)), frame);
}

TEST(Parts, RestsWithoutABeginningSayNothing) {
  PartCollector collector(1 << 20);
  auto parts = Cut(MakeFrame(20'000), 1);
  parts.erase(parts.begin());
  EXPECT_FALSE(AddAll(collector, parts));
}

TEST(Parts, RefusesWhatWasNotCutSo) {
  PartCollector collector(10'000);
  const auto parts = Cut(MakeFrame(9'000), 1);
  EXPECT_EQ(collector.Add({}).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(collector.Add(std::span(parts[0]).first(15)).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(collector.Add(std::span(parts[0]).first(900)).error().code, ErrorCode::kCorrupt);
  Bytes elsewhere = parts[1];
  elsewhere[12] += 1;  // the offset
  EXPECT_EQ(collector.Add(elsewhere).error().code, ErrorCode::kCorrupt);
  const auto large = collector.Add(Cut(MakeFrame(10'001), 2).front());
  ASSERT_FALSE(large.ok());
  EXPECT_EQ(large.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(large.error().message, testing::HasSubstr("10001"));
}

}  // namespace
}  // namespace waymark::session::wire

// SPDX-License-Identifier: Apache-2.0
#include "session/wire/outbox.h"

#include <gmock/gmock.h>

namespace waymark::session::wire {
namespace {

using Frame = std::vector<std::uint8_t>;
using Outcome = Outbox::Outcome;

TEST(Outbox, KeepsTheOrderAndSaysWhenToBegin) {
  Outbox outbox(100);
  EXPECT_EQ(outbox.Push({1}, std::nullopt), Outcome::kFirst);
  EXPECT_EQ(outbox.Push({2}, std::nullopt), Outcome::kQueued);
  EXPECT_EQ(outbox.Pop(), Frame{1});
  EXPECT_EQ(outbox.Pop(), Frame{2});
  EXPECT_EQ(outbox.Pop(), std::nullopt);
  EXPECT_EQ(outbox.Push({3}, std::nullopt), Outcome::kFirst);
}

TEST(Outbox, ANewerOneTakesThePlaceOfItsSlot) {
  Outbox outbox(100);
  outbox.Push({1}, Slot{5});
  outbox.Push({2}, std::nullopt);
  outbox.Push({3, 3}, Slot{5});
  outbox.Push({4}, Slot{6});
  EXPECT_EQ(outbox.Pop(), (Frame{3, 3}));
  EXPECT_EQ(outbox.Push({5}, Slot{5}), Outcome::kQueued) << "the place is free again";
  EXPECT_EQ(outbox.Pop(), Frame{2});
  EXPECT_EQ(outbox.Pop(), Frame{4});
  EXPECT_EQ(outbox.Pop(), Frame{5});
}

TEST(Outbox, HoldsNoMoreThanItsBytes) {
  Outbox outbox(10);
  EXPECT_EQ(outbox.Push(Frame(6), Slot{1}), Outcome::kFirst);
  EXPECT_EQ(outbox.Push(Frame(5), std::nullopt), Outcome::kFull);
  EXPECT_EQ(outbox.Push(Frame(10), Slot{1}), Outcome::kQueued) << "in the place of the first";
  EXPECT_EQ(outbox.Push(Frame(1), std::nullopt), Outcome::kFull);
  EXPECT_EQ(outbox.Pop(), Frame(10));
  outbox.Push(Frame(9), Slot{1});
  outbox.Clear();
  EXPECT_EQ(outbox.Push(Frame(10), Slot{1}), Outcome::kFirst);
}

TEST(Outbox, OldPosesMakeWayAndAnchorsDoNot) {
  PoseBatch first, second;
  second.chunk = 1;
  EXPECT_EQ(SlotOf(Downward(first)), SlotOf(Downward(first)));
  EXPECT_NE(SlotOf(Downward(first)), SlotOf(Downward(second)));
  EXPECT_EQ(SlotOf(Downward(AnchorGone{AnchorId("a")})), std::nullopt);
  EXPECT_EQ(SlotOf(Upward(AnchorCommand{.anchor = AnchorId("a")})), std::nullopt);
  EXPECT_TRUE(SlotOf(Upward(ClockPing{})).has_value());
}

}  // namespace
}  // namespace waymark::session::wire

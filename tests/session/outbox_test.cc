// SPDX-License-Identifier: Apache-2.0
#include "session/wire/outbox.h"

#include <gmock/gmock.h>

namespace waymark::session::wire {
namespace {

using Frame = std::vector<std::uint8_t>;
using Outcome = Outbox::Outcome;

Outcome Push(Outbox& outbox, Frame frame, std::optional<Slot> slot) {
  return outbox.Push(Share(std::move(frame)), slot);
}

Frame Pop(Outbox& outbox) { return *outbox.Pop(); }

TEST(Outbox, KeepsTheOrderAndSaysWhenToBegin) {
  Outbox outbox(100);
  EXPECT_EQ(Push(outbox, {1}, std::nullopt), Outcome::kFirst);
  EXPECT_EQ(Push(outbox, {2}, std::nullopt), Outcome::kQueued);
  EXPECT_EQ(Pop(outbox), Frame{1});
  EXPECT_EQ(Pop(outbox), Frame{2});
  EXPECT_EQ(outbox.Pop(), nullptr);
  EXPECT_EQ(Push(outbox, {3}, std::nullopt), Outcome::kFirst);
}

TEST(Outbox, ANewerOneTakesThePlaceOfItsSlot) {
  Outbox outbox(100);
  Push(outbox, {1}, Slot{5});
  Push(outbox, {2}, std::nullopt);
  Push(outbox, {3, 3}, Slot{5});
  Push(outbox, {4}, Slot{6});
  EXPECT_EQ(Pop(outbox), (Frame{3, 3}));
  EXPECT_EQ(Push(outbox, {5}, Slot{5}), Outcome::kQueued) << "the place is free again";
  EXPECT_EQ(Pop(outbox), Frame{2});
  EXPECT_EQ(Pop(outbox), Frame{4});
  EXPECT_EQ(Pop(outbox), Frame{5});
}

TEST(Outbox, HoldsNoMoreThanItsBytes) {
  Outbox outbox(10);
  EXPECT_EQ(Push(outbox, Frame(6), Slot{1}), Outcome::kFirst);
  EXPECT_EQ(Push(outbox, Frame(5), std::nullopt), Outcome::kFull);
  EXPECT_EQ(Push(outbox, Frame(10), Slot{1}), Outcome::kQueued) << "in the place of the first";
  EXPECT_EQ(Push(outbox, Frame(1), std::nullopt), Outcome::kFull);
  EXPECT_EQ(Pop(outbox), Frame(10));
  Push(outbox, Frame(9), Slot{1});
  outbox.Clear();
  EXPECT_EQ(Push(outbox, Frame(10), Slot{1}), Outcome::kFirst);
}

TEST(Outbox, PartsGoLastAndMakeWayForThoseOfANewerOne) {
  Outbox outbox(100);
  EXPECT_TRUE(outbox.PushParts({Share({1}), Share({2, 2}), Share({3})}));
  EXPECT_EQ(Push(outbox, {9}, std::nullopt), Outcome::kQueued);
  EXPECT_EQ(Pop(outbox), Frame{9});
  EXPECT_EQ(Pop(outbox), Frame{1});
  EXPECT_EQ(outbox.WaitingPartBytes(), 3u);
  EXPECT_FALSE(outbox.PushParts({Share({4})}));
  EXPECT_EQ(Pop(outbox), Frame{4});
  EXPECT_EQ(outbox.Pop(), nullptr);
  EXPECT_EQ(outbox.WaitingPartBytes(), 0u);
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

// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/tile_desk.h"

#include <gmock/gmock.h>

#include "tests/session/pictured_map.h"

namespace waymark::session::internal {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const Instant kStart{seconds(5000)};

DeviceFrame FrameAt(std::chrono::nanoseconds time) {
  return {.width_px = 0,
          .height_px = 0,
          .pixels = {},
          .camera = support::TestCamera(),
          .device_from_camera = {},
          .vo_from_device = {},
          .time = DeviceTime(time)};
}

/// A frame every second, from the start on.
class ATileDesk : public testing::Test {
 protected:
  bool OfferAfter(milliseconds time, bool is_connected = true) {
    const bool is_taken = desk_.Offer(FrameAt(time), kStart + time, is_connected);
    if (is_taken) {
      EXPECT_TRUE(desk_.TakeFrame().has_value());
      desk_.Finish();
    }
    return is_taken;
  }

  TileDesk desk_{seconds(1), seconds(2)};
};

TEST_F(ATileDesk, IsNotAskedWhileTheServerAnswers) {
  for (int second = 0; second < 10; ++second) {
    desk_.OnAsked(kStart + seconds(second));
    EXPECT_FALSE(OfferAfter(milliseconds(1000 * second + 900))) << second;
    desk_.OnAnswer(false);
  }
  EXPECT_FALSE(OfferAfter(seconds(60))) << "nobody asked for a while";
}

TEST_F(ATileDesk, IsAskedAfterASilenceUntilAnAnswer) {
  desk_.OnAsked(kStart);
  desk_.OnAsked(kStart + seconds(1));  // the one before is given up, and no answer
  EXPECT_FALSE(OfferAfter(milliseconds(1999)));
  EXPECT_TRUE(OfferAfter(milliseconds(2000)));
  EXPECT_FALSE(OfferAfter(milliseconds(2900))) << "one a second";
  EXPECT_TRUE(OfferAfter(milliseconds(3000)));
  desk_.OnAnswer(false);
  EXPECT_FALSE(OfferAfter(milliseconds(4000)));
}

TEST_F(ATileDesk, IsAskedAtOnceWhenTheServerIsBusyOrTheWayIsLost) {
  EXPECT_TRUE(OfferAfter(milliseconds(0), false));
  EXPECT_FALSE(OfferAfter(milliseconds(1000)));
  desk_.OnAsked(kStart);
  desk_.OnAnswer(true);
  EXPECT_TRUE(OfferAfter(milliseconds(2000)));
  desk_.OnAnswer(false);
  EXPECT_FALSE(OfferAfter(milliseconds(3000)));
}

TEST_F(ATileDesk, HasTheNewestFrameAndOneUnderWay) {
  EXPECT_TRUE(desk_.Offer(FrameAt(seconds(1)), kStart, false));
  EXPECT_TRUE(desk_.Offer(FrameAt(seconds(2)), kStart, false));
  EXPECT_EQ(desk_.TakeFrame()->time, DeviceTime(seconds(2)));
  EXPECT_FALSE(desk_.HasFrame());
  EXPECT_FALSE(desk_.Offer(FrameAt(seconds(3)), kStart, false));
  desk_.ShiftTime(seconds(100));
  EXPECT_EQ(desk_.Finish().time, DeviceTime(seconds(102)));
  EXPECT_TRUE(desk_.Offer(FrameAt(seconds(103)), kStart, false));
}

}  // namespace
}  // namespace waymark::session::internal

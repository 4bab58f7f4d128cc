// SPDX-License-Identifier: Apache-2.0
// Messages as bytes, of which anybody may have written any.
#include "session/wire/frames.h"

#include <random>
#include <vector>

#include "tests/session/wire_fixture.h"

namespace waymark::session::wire {
namespace {

using Frame = std::vector<std::uint8_t>;

std::vector<Frame> MakeUpwardFrames() {
  support::RandomGeometry random(1);
  const LivePose pose{.time = {}, .map_from_device = Transform<Map, Device>(random.Rigid())};
  std::vector<Frame> frames;
  for (const Upward& message :
       {Upward(MakeHello()), Upward(Farewell{kDevice}), Upward(PoseReport{Ticket{7}, pose}),
        Upward(MakeQuery()), Upward(MakeCommand(random)), Upward(ClockPing{Ticket{7}, 3, {}})}) {
    frames.push_back(EncodeFrame(message));
  }
  return frames;
}

TEST(Frames, EndsComeBack) {
  const auto farewell = DecodeUpward(EncodeFrame(Upward(Farewell{kDevice})));
  ASSERT_TRUE(farewell.ok()) << ToString(farewell.error());
  EXPECT_EQ(std::get<Farewell>(*farewell).device, kDevice);
  const auto gone = DecodeDownward(EncodeFrame(Downward(DeviceGone{kDevice})));
  ASSERT_TRUE(gone.ok()) << ToString(gone.error());
  EXPECT_EQ(std::get<DeviceGone>(*gone).device, kDevice);
  for (const bool is_own : {false, true}) {
    const auto ended = DecodeDownward(EncodeFrame(Downward(AnchorGone{kAnchor, is_own})));
    ASSERT_TRUE(ended);
    EXPECT_EQ(std::get<AnchorGone>(*ended).is_own, is_own);
  }
  const auto deleted = DecodeDownward(EncodeFrame(Downward(AnchorGone{kAnchor})));
  ASSERT_TRUE(deleted.ok()) << ToString(deleted.error());
  EXPECT_EQ(std::get<AnchorGone>(*deleted).anchor, kAnchor);
}

TEST(Frames, OnlyAHelloEnds) {
  for (Frame frame : MakeUpwardFrames()) {
    if (frame[0] == 1) continue;
    frame[1] = 1;
    EXPECT_FALSE(DecodeUpward(frame).ok()) << int{frame[0]};
  }
}

TEST(Frames, WhatTheServerSaysIsNoMessageOfADevice) {
  EXPECT_FALSE(DecodeUpward(EncodeFrame(Downward(DeviceGone{kDevice}))).ok());
  EXPECT_FALSE(DecodeDownward(EncodeFrame(Upward(MakeHello()))).ok());
  EXPECT_FALSE(DecodeUpward({}).ok());
  EXPECT_FALSE(DecodeUpward(Frame{99, 0, 0, 0, 1, 2, 3, 4}).ok());
}

TEST(Frames, APartIsNoMessage) {
  for (const Frame& frame : MakeUpwardFrames()) {
    ASSERT_TRUE(DecodeUpward(frame).ok());
    for (std::size_t size = 0; size < frame.size(); ++size) {
      EXPECT_FALSE(DecodeUpward(std::span(frame).first(size)).ok())
          << int{frame[0]} << ": " << size << " of " << frame.size();
    }
    Frame longer = frame;
    longer.resize(frame.size() + 8);
    EXPECT_FALSE(DecodeUpward(longer).ok()) << int{frame[0]};
  }
}

TEST(Frames, AnyBytesAreDecodedOrRefused) {
  std::mt19937_64 random(1);
  int refused = 0;
  for (const Frame& frame : MakeUpwardFrames()) {
    for (int i = 0; i < 20000; ++i) {
      Frame changed = frame;
      for (int flips = 1 + static_cast<int>(random() % 4); flips > 0; --flips) {
        changed[random() % changed.size()] = static_cast<std::uint8_t>(random());
      }
      const auto decoded = DecodeUpward(changed);
      refused += !decoded;
      if (!decoded) continue;
      const auto again = DecodeUpward(EncodeFrame(*decoded));
      EXPECT_TRUE(again.ok()) << "what was understood can be said: " << ToString(again.error());
    }
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace waymark::session::wire

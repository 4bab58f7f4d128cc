// SPDX-License-Identifier: Apache-2.0
#include "session/device/image_sizer.h"

#include <gtest/gtest.h>

namespace waymark::session {
namespace {

constexpr std::chrono::seconds kInterval{1};

std::size_t IndexOf(const ImageSize& size) {
  const auto steps = ImageSteps();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].size == size) return i;
  }
  ADD_FAILURE() << "no step";
  return 0;
}

/// Sends images over a network of this rate until the choice has settled.
ImageSizer After(double bits_per_s, int images = 10, double detail = 1) {
  ImageSizer sizer(kInterval);
  for (int i = 0; i < images; ++i) {
    const ImageSize size = sizer.Choose();
    const double bytes = detail * ImageSteps()[IndexOf(size)].typical_bytes;
    sizer.OnEncoded(size, static_cast<std::size_t>(bytes));
    sizer.OnArrived(static_cast<std::size_t>(bytes), 8 * bytes / bits_per_s);
    sizer.OnAnswer(true);
  }
  return sizer;
}

TEST(ImageSteps, GrowInBytesAndInWhatIsFound) {
  const auto steps = ImageSteps();
  for (std::size_t i = 1; i < steps.size(); ++i) {
    EXPECT_GT(steps[i].typical_bytes, steps[i - 1].typical_bytes);
    EXPECT_GE(steps[i].found_share, steps[i - 1].found_share);
  }
}

TEST(ImageSizer, FasterNetworksCarryLargerImages) {
  std::size_t before = 0;
  for (const double rate : {1e5, 7e5, 5e6, 5e7, 1e9}) {
    const std::size_t now = IndexOf(After(rate).Choose());
    EXPECT_GE(now, before) << rate;
    before = now;
  }
  EXPECT_EQ(IndexOf(After(1e5).Choose()), 0u);
  EXPECT_EQ(before, ImageSteps().size() - 1);
}

TEST(ImageSizer, ImagesOfMuchDetailAreSentSmaller) {
  EXPECT_LE(IndexOf(After(2e6, 10, 2.5).Choose()), IndexOf(After(2e6, 10, 0.5).Choose()));
  EXPECT_EQ(After(1e9, 10, 2).ExpectedBytes(),
            static_cast<std::size_t>(2 * ImageSteps().back().typical_bytes));
}

TEST(ImageSizer, OneLatePacketChangesNothing) {
  ImageSizer sizer = After(5e6);
  const ImageSize before = sizer.Choose();
  sizer.OnArrived(20'000, 3);
  EXPECT_EQ(sizer.Choose(), before);
}

TEST(ImageSizer, WhatWasGivenUpMakesItCautious) {
  ImageSizer sizer = After(5e6);
  const std::size_t before = IndexOf(sizer.Choose());
  for (int i = 0; i < 8; ++i) sizer.OnTooSlow();
  EXPECT_EQ(IndexOf(sizer.Choose()), 0u);
  for (int i = 0; i < 5; ++i) sizer.OnArrived(10'000, 8 * 10'000 / 5e6);
  EXPECT_EQ(IndexOf(sizer.Choose()), before) << "the network recovered";
}

TEST(ImageSizer, WhereImagesAreNotFoundItSendsLargerOnes) {
  ImageSizer sizer = After(7e5);
  const std::size_t before = IndexOf(sizer.Choose());
  for (int i = 0; i < 6; ++i) sizer.OnAnswer(false);
  EXPECT_GT(IndexOf(sizer.Choose()), before);
  sizer.OnAnswer(true);
  EXPECT_EQ(IndexOf(sizer.Choose()), before);
}

}  // namespace
}  // namespace waymark::session

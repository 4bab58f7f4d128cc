// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "mapping/features/features.h"
#include "mapping/features/internal/image_header.h"

namespace waymark::mapping {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Brightness rises to the right and down, with a little noise so that JPEG has work to do.
cv::Mat Slope(int width_px, int height_px) {
  std::mt19937 random(1);
  cv::Mat image(height_px, width_px, CV_8UC1);
  for (int row = 0; row < height_px; ++row) {
    for (int column = 0; column < width_px; ++column) {
      image.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(
          100 * column / width_px + 100 * row / height_px + static_cast<int>(random() % 8));
    }
  }
  return image;
}

Bytes Encode(const char* extension, const cv::Mat& image, const std::vector<int>& options = {}) {
  Bytes bytes;
  EXPECT_TRUE(cv::imencode(extension, image, bytes, options));
  return bytes;
}

/// A segment that says: show this image turned by a quarter.
Bytes WithExifOrientation(const Bytes& jpeg) {
  const Bytes exif = {0xff, 0xe1, 0, 34, 'E', 'x', 'i', 'f', 0, 0, 'I', 'I',  // TIFF, Intel order
                      42,   0,    8, 0,  0,   0,   1,   0,                    // one entry
                      0x12, 0x01, 3, 0,  1,   0,   0,   0,   6, 0, 0,   0,    // orientation 6
                      0,    0,    0, 0};
  Bytes bytes(jpeg.begin(), jpeg.begin() + 2);
  bytes.insert(bytes.end(), exif.begin(), exif.end());
  bytes.insert(bytes.end(), jpeg.begin() + 2, jpeg.end());
  return bytes;
}

ErrorCode CodeOf(const Bytes& bytes) {
  const auto image = DecodeGrayImage(bytes);
  EXPECT_FALSE(image.ok());
  return image.ok() ? ErrorCode::kConflict : image.error().code;
}

TEST(DecodeGrayImage, PngKeepsEveryPixel) {
  const cv::Mat pixels = Slope(37, 23);
  const auto image = DecodeGrayImage(Encode(".png", pixels));
  ASSERT_TRUE(image.ok()) << ToString(image.error());
  EXPECT_EQ(image->width_px, 37);
  EXPECT_EQ(image->height_px, 23);
  ASSERT_EQ(image->pixels.size(), 37 * 23);
  EXPECT_EQ(std::memcmp(image->pixels.data(), pixels.data, image->pixels.size()), 0);
}

TEST(DecodeGrayImage, JpegIsCloseAndProgressiveIsRead) {
  const cv::Mat pixels = Slope(640, 360);
  for (const int progressive : {0, 1}) {
    const auto image =
        DecodeGrayImage(Encode(".jpg", pixels, {cv::IMWRITE_JPEG_PROGRESSIVE, progressive}));
    ASSERT_TRUE(image.ok()) << ToString(image.error());
    ASSERT_EQ(image->pixels.size(), 640 * 360);
    double sum = 0;
    for (std::size_t i = 0; i < image->pixels.size(); ++i) {
      sum += std::abs(image->pixels[i] - pixels.data[i]);
    }
    EXPECT_LT(sum / static_cast<double>(image->pixels.size()), 3);
  }
}

TEST(DecodeGrayImage, ColourBecomesLuminance) {
  const cv::Mat red(8, 8, CV_8UC3, cv::Scalar(0, 0, 255));
  for (const char* const extension : {".jpg", ".png"}) {
    const auto image = DecodeGrayImage(Encode(extension, red));
    ASSERT_TRUE(image.ok()) << ToString(image.error());
    EXPECT_NEAR(image->pixels[0], 0.299 * 255, 2) << extension;
  }
}

TEST(DecodeGrayImage, ExifOrientationIsIgnored) {
  const Bytes turned = WithExifOrientation(Encode(".jpg", Slope(64, 32)));
  ASSERT_EQ(cv::imdecode(turned, cv::IMREAD_GRAYSCALE).cols, 32) << "the tag should be legible";
  const auto image = DecodeGrayImage(turned);
  ASSERT_TRUE(image.ok()) << ToString(image.error());
  EXPECT_EQ(image->width_px, 64);
}

TEST(DecodeGrayImage, EveryTruncationIsCorrupt) {
  for (const Bytes& whole : {Encode(".png", Slope(60, 40)), Encode(".jpg", Slope(60, 40)),
                             Encode(".jpg", Slope(60, 40), {cv::IMWRITE_JPEG_PROGRESSIVE, 1})}) {
    ASSERT_TRUE(DecodeGrayImage(whole).ok());
    for (std::size_t size = 0; size < whole.size(); ++size) {
      // PNG may miss the checksum of its last, empty chunk; nothing is lost by refusing it.
      EXPECT_EQ(CodeOf(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))),
                ErrorCode::kCorrupt)
          << size << " of " << whole.size();
    }
  }
}

TEST(DecodeGrayImage, BytesBehindTheEndAreIgnored) {
  Bytes jpeg = Encode(".jpg", Slope(60, 40));
  jpeg.insert(jpeg.end(), 1000, 0x55);  // phones append previews and motion pictures
  EXPECT_TRUE(DecodeGrayImage(jpeg).ok());
}

TEST(DecodeGrayImage, GarbageIsCorruptAndHarmless) {
  std::mt19937 random(2);
  for (const Bytes& start : {Bytes{}, Encode(".png", Slope(4, 4)), Encode(".jpg", Slope(4, 4))}) {
    for (int i = 0; i < 100; ++i) {
      Bytes bytes(start.begin(), start.begin() + std::min<std::ptrdiff_t>(start.size(), 10));
      while (bytes.size() < 500) bytes.push_back(static_cast<std::uint8_t>(random()));
      EXPECT_EQ(CodeOf(bytes), ErrorCode::kCorrupt);
    }
  }
}

TEST(DecodeGrayImage, DamageNeverDoesMoreThanFail) {
  std::mt19937 random(3);
  for (const Bytes& whole : {Encode(".png", Slope(60, 40)), Encode(".jpg", Slope(60, 40))}) {
    for (int i = 0; i < 500; ++i) {
      Bytes damaged = whole;
      for (int j = 0; j < 3; ++j) {
        damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
      }
      const auto image = DecodeGrayImage(damaged);
      if (image.ok()) {
        EXPECT_EQ(image->pixels.size(),
                  static_cast<std::size_t>(image->width_px) * image->height_px);
      }
    }
  }
}

TEST(DecodeGrayImage, HugeSizesAreRefusedBeforeAllocation) {
  Bytes png = Encode(".png", Slope(8, 8));
  const Bytes huge = {0x7f, 0xff, 0xff, 0xff};
  std::copy(huge.begin(), huge.end(), png.begin() + 16);  // width
  std::copy(huge.begin(), huge.end(), png.begin() + 20);  // height
  EXPECT_EQ(CodeOf(png), ErrorCode::kUnsupported);

  Bytes jpeg = Encode(".jpg", Slope(8, 8));
  const Bytes frame = {0xff, 0xc0};
  const auto found = std::search(jpeg.begin(), jpeg.end(), frame.begin(), frame.end());
  ASSERT_NE(found, jpeg.end());
  std::fill(found + 5, found + 9, std::uint8_t{0xff});  // 65535 x 65535
  EXPECT_EQ(CodeOf(jpeg), ErrorCode::kUnsupported);
}

TEST(DecodeGrayImage, ThousandsOfScansAreRefused) {
  Bytes jpeg = Encode(".jpg", Slope(64, 64), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  const Bytes start_of_scan = {0xff, 0xda};
  const auto last =
      std::find_end(jpeg.begin(), jpeg.end(), start_of_scan.begin(), start_of_scan.end());
  const Bytes scan(last, jpeg.end() - 2);
  for (int i = 0; i < 1000; ++i) jpeg.insert(jpeg.end() - 2, scan.begin(), scan.end());
  EXPECT_EQ(CodeOf(jpeg), ErrorCode::kUnsupported);
}

TEST(DecodeImageHeader, ZeroSizesAreCorrupt) {
  Bytes png = Encode(".png", Slope(8, 8));
  std::fill(png.begin() + 16, png.begin() + 20, std::uint8_t{0});
  EXPECT_FALSE(internal::DecodeImageHeader(png).ok());
}

TEST(DecodeImageHeader, ReadsTheSizeOfBothFormats) {
  for (const char* const extension : {".jpg", ".png"}) {
    const auto header = internal::DecodeImageHeader(Encode(extension, Slope(300, 20)));
    ASSERT_TRUE(header.ok());
    EXPECT_EQ(header->width_px, 300);
    EXPECT_EQ(header->height_px, 20);
  }
}

}  // namespace
}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
// Compressed images come from phones: nothing is less trusted.
#include <opencv2/imgcodecs.hpp>

#include "mapping/base/check.h"
#include "mapping/features/features.h"
#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {

std::vector<Bytes> Seeds() {
  cv::Mat picture(24, 32, CV_8UC3);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      picture.at<cv::Vec3b>(y, x) =
          cv::Vec3b(static_cast<std::uint8_t>(x * 8), static_cast<std::uint8_t>(y * 10),
                    static_cast<std::uint8_t>(x ^ y));
    }
  }
  std::vector<Bytes> seeds(3);
  cv::imencode(".jpg", picture, seeds[0]);
  cv::imencode(".png", picture, seeds[1]);
  cv::imencode(".jpg", picture, seeds[2], {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  return seeds;
}

void TryOne(std::span<const std::uint8_t> bytes) {
  const auto image = mapping::DecodeGrayImage(bytes);
  if (!image) return;
  CHECK(image->width_px > 0 && image->height_px > 0, "an empty image");
  CHECK(image->pixels.size() ==
            static_cast<std::size_t>(image->width_px) * static_cast<std::size_t>(image->height_px),
        "{} pixels of {} x {}", image->pixels.size(), image->width_px, image->height_px);
}

}  // namespace waymark::fuzz

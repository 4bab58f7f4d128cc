// SPDX-License-Identifier: Apache-2.0
#include "session/device/jpeg.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace waymark::session {
namespace {

cv::Mat Reduce(const cv::Mat& image, int max_side_px) {
  const int side = std::max(image.cols, image.rows);
  if (side <= max_side_px) return image;
  const double scale = static_cast<double>(max_side_px) / side;
  const auto reduced = [&](int px) {
    return std::max(1, static_cast<int>(std::lround(px * scale)));
  };
  cv::Mat smaller;
  cv::resize(image, smaller, {reduced(image.cols), reduced(image.rows)}, 0, 0, cv::INTER_AREA);
  return smaller;
}

}  // namespace

Result<EncodedImage> EncodeJpeg(std::span<const std::uint8_t> pixels, int width_px, int height_px,
                                const ImageSize& size) {
  const std::int64_t expected = std::int64_t{width_px} * height_px;
  if (width_px <= 0 || height_px <= 0 || static_cast<std::int64_t>(pixels.size()) != expected) {
    return MakeError(ErrorCode::kInvalidArgument, "frame: expected {} x {} pixels, found {} bytes",
                     width_px, height_px, pixels.size());
  }
  try {
    // OpenCV knows no read-only image; neither call writes to it.
    const cv::Mat image(height_px, width_px, CV_8UC1, const_cast<std::uint8_t*>(pixels.data()));
    const cv::Mat reduced = Reduce(image, size.max_side_px);
    EncodedImage encoded{.jpeg = {}, .width_px = reduced.cols, .height_px = reduced.rows};
    if (cv::imencode(".jpg", reduced, encoded.jpeg, {cv::IMWRITE_JPEG_QUALITY, size.quality})) {
      return encoded;
    }
  } catch (const cv::Exception& exception) {
    return MakeError(ErrorCode::kUnavailable, "frame: JPEG encoding failed: {}", exception.what());
  }
  return MakeError(ErrorCode::kUnavailable, "frame: JPEG encoding failed");
}

}  // namespace waymark::session

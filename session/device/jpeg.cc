// SPDX-License-Identifier: Apache-2.0
#include "session/device/jpeg.h"

#include <opencv2/imgcodecs.hpp>

namespace waymark::session {

Result<std::vector<std::uint8_t>> EncodeJpeg(std::span<const std::uint8_t> pixels, int width_px,
                                             int height_px, int quality) {
  const std::int64_t expected = std::int64_t{width_px} * height_px;
  if (width_px <= 0 || height_px <= 0 || static_cast<std::int64_t>(pixels.size()) != expected) {
    return MakeError(ErrorCode::kInvalidArgument, "frame: expected {} x {} pixels, found {} bytes",
                     width_px, height_px, pixels.size());
  }
  try {
    // OpenCV knows no read-only image; imencode does not write to it.
    const cv::Mat image(height_px, width_px, CV_8UC1, const_cast<std::uint8_t*>(pixels.data()));
    std::vector<std::uint8_t> bytes;
    if (cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality})) return bytes;
  } catch (const cv::Exception& exception) {
    return MakeError(ErrorCode::kUnavailable, "frame: JPEG encoding failed: {}", exception.what());
  }
  return MakeError(ErrorCode::kUnavailable, "frame: JPEG encoding failed");
}

}  // namespace waymark::session

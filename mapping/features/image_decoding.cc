// SPDX-License-Identifier: Apache-2.0
#include <opencv2/imgcodecs.hpp>

#include "mapping/features/features.h"
#include "mapping/features/internal/image_header.h"
#include "mapping/features/internal/opencv_setup.h"

namespace waymark::mapping {
namespace {

constexpr std::int64_t kMaxPixels = 100'000'000;

}  // namespace

Result<GrayImage> DecodeGrayImage(std::span<const std::uint8_t> bytes) {
  WAYMARK_TRY_ASSIGN(const internal::ImageHeader header, internal::DecodeImageHeader(bytes));
  if (header.width_px > kMaxPixels / header.height_px) {
    return MakeError(ErrorCode::kUnsupported, "image: expected at most {} pixels, found {} x {}",
                     kMaxPixels, header.width_px, header.height_px);
  }
  internal::SetUpOpenCv();
  cv::Mat decoded;
  try {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                          const_cast<std::uint8_t*>(bytes.data()));  // imdecode only reads
    decoded = cv::imdecode(encoded, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const std::exception& exception) {
    return MakeError(ErrorCode::kCorrupt, "image of {} x {}: {}", header.width_px, header.height_px,
                     exception.what());
  }
  if (decoded.type() != CV_8UC1 || decoded.cols != header.width_px ||
      decoded.rows != header.height_px) {
    return MakeError(ErrorCode::kCorrupt, "image of {} x {}: {} bytes do not decode to its pixels",
                     header.width_px, header.height_px, bytes.size());
  }
  GrayImage image{.width_px = decoded.cols, .height_px = decoded.rows, .pixels = {}};
  image.pixels.reserve(decoded.total());
  for (int row = 0; row < decoded.rows; ++row) {
    const std::uint8_t* const begin = decoded.ptr<std::uint8_t>(row);
    image.pixels.insert(image.pixels.end(), begin, begin + decoded.cols);
  }
  return image;
}

}  // namespace waymark::mapping

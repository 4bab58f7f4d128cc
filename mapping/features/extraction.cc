// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mapping/features/features.h"
#include "mapping/features/internal/opencv_setup.h"
#include "mapping/features/internal/sift.h"
#include "mapping/features/internal/sift_kernel_sets.h"

namespace waymark::mapping {
namespace {

cv::Mat ReduceToSide(const cv::Mat& image, int max_side_px) {
  const int side_px = std::max(image.cols, image.rows);
  if (side_px <= max_side_px) return image;
  const double scale = static_cast<double>(max_side_px) / side_px;
  const auto reduced = [&](int length) {
    return std::max(1, static_cast<int>(std::lround(scale * length)));
  };
  cv::Mat small;
  cv::resize(image, small, cv::Size(reduced(image.cols), reduced(image.rows)), 0, 0,
             cv::INTER_AREA);
  return small;
}

Result<cv::Mat> Reduce(const GrayImage& image, int max_side_px) {
  internal::SetUpOpenCv();
  try {
    const cv::Mat full(image.height_px, image.width_px, CV_8UC1,
                       const_cast<std::uint8_t*>(image.pixels.data()));  // only read
    return ReduceToSide(full, max_side_px);
  } catch (const std::exception& exception) {
    return MakeError(ErrorCode::kUnavailable, "reduction of an image of {} x {}: {}",
                     image.width_px, image.height_px, exception.what());
  }
}

}  // namespace

Result<void> FeatureOptions::Validate() const {
  if (max_features < 1 || max_features > 100'000) {
    return MakeError(ErrorCode::kInvalidArgument, "max_features: expected 1 to 100000, found {}",
                     max_features);
  }
  if (!(contrast_threshold > 0 && contrast_threshold <= 1)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "contrast_threshold: expected a number in (0, 1], found {}",
                     contrast_threshold);
  }
  if (!(smoothing_px >= 0 && smoothing_px <= 10)) {
    return MakeError(ErrorCode::kInvalidArgument, "smoothing_px: expected 0 to 10, found {}",
                     smoothing_px);
  }
  if (max_image_side_px < 16 || max_image_side_px > 16'384) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "max_image_side_px: expected 16 to 16384, found {}", max_image_side_px);
  }
  return {};
}

Result<ImageFeatures> ExtractFeatures(const GrayImage& image, const FeatureOptions& options) {
  WAYMARK_TRY(options.Validate());
  if (image.width_px < 0 || image.height_px < 0 ||
      image.pixels.size() !=
          static_cast<std::size_t>(image.width_px) * static_cast<std::size_t>(image.height_px)) {
    return MakeError(ErrorCode::kInvalidArgument, "image of {} x {}: found {} pixels",
                     image.width_px, image.height_px, image.pixels.size());
  }
  if (image.pixels.empty()) return ImageFeatures{};
  WAYMARK_TRY_ASSIGN(const cv::Mat reduced, Reduce(image, options.max_image_side_px));
  const auto scale_x = static_cast<float>(image.width_px) / static_cast<float>(reduced.cols);
  const auto scale_y = static_cast<float>(image.height_px) / static_cast<float>(reduced.rows);
  const float scale = std::sqrt(scale_x * scale_y);
  WAYMARK_TRY_ASSIGN(
      ImageFeatures features,
      internal::ExtractSift(
          {reduced.data, static_cast<std::ptrdiff_t>(reduced.step), reduced.cols, reduced.rows},
          {.smoothing_px = options.smoothing_px / scale,
           .extrema = {.contrast_threshold = options.contrast_threshold}},
          options.max_features, internal::SupportedSiftKernels().front()));
  for (Keypoint& keypoint : features.keypoints) {
    keypoint.x_px *= scale_x;
    keypoint.y_px *= scale_y;
    keypoint.scale_px *= scale;
  }
  return features;
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/features/reference_sift.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

namespace waymark::mapping {
namespace {

// OpenCV takes pixel 2i of the doubled image for pixel i, where it lies at i - 0.25.
constexpr float kCornerFromOpenCv_px = 0.25F;

cv::Mat Prepare(const GrayImage& image, const FeatureOptions& options) {
  const cv::Mat full(image.height_px, image.width_px, CV_8UC1,
                     const_cast<std::uint8_t*>(image.pixels.data()));  // only read
  cv::Mat smooth = full, small;
  if (options.smoothing_px > 0) {
    smooth = cv::Mat();
    cv::GaussianBlur(full, smooth, cv::Size(), options.smoothing_px);
  }
  const double scale =
      static_cast<double>(options.max_image_side_px) / std::max(image.width_px, image.height_px);
  if (scale >= 1) return smooth;
  const cv::Size size(static_cast<int>(std::lround(scale * image.width_px)),
                      static_cast<int>(std::lround(scale * image.height_px)));
  cv::resize(smooth, small, size, 0, 0, cv::INTER_AREA);
  return small;
}

Descriptor RootSift(std::span<const float, 128> histogram) {
  const float sum = std::accumulate(histogram.begin(), histogram.end(), 0.0F);
  const float scale = sum > 0 ? 512.0F / std::sqrt(sum) : 0.0F;
  Descriptor descriptor;
  std::transform(histogram.begin(), histogram.end(), descriptor.begin(), [&](float value) {
    return static_cast<std::uint8_t>(std::min(255.0F, std::sqrt(value) * scale + 0.5F));
  });
  return descriptor;
}

std::vector<int> OrderByStrength(const std::vector<cv::KeyPoint>& keypoints, int max_features) {
  std::vector<int> order(keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return std::tuple(-keypoints[a].response, a) < std::tuple(-keypoints[b].response, b);
  });
  if (order.size() > static_cast<std::size_t>(max_features)) order.resize(max_features);
  return order;
}

}  // namespace

Result<ImageFeatures> ExtractWithOpenCv(const GrayImage& image, const FeatureOptions& options) {
  try {
    cv::setNumThreads(1);
    const cv::Mat prepared = Prepare(image, options);
    const float scale_x = static_cast<float>(image.width_px) / static_cast<float>(prepared.cols);
    const float scale_y = static_cast<float>(image.height_px) / static_cast<float>(prepared.rows);
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat histograms;
    cv::SIFT::create(options.max_features, 3, options.contrast_threshold)
        ->detectAndCompute(prepared, cv::noArray(), keypoints, histograms);
    ImageFeatures features;
    for (const int index : OrderByStrength(keypoints, options.max_features)) {
      const cv::KeyPoint& keypoint = keypoints[index];
      features.keypoints.push_back({.x_px = (keypoint.pt.x + kCornerFromOpenCv_px) * scale_x,
                                    .y_px = (keypoint.pt.y + kCornerFromOpenCv_px) * scale_y,
                                    .scale_px = keypoint.size * std::sqrt(scale_x * scale_y),
                                    .angle_rad = keypoint.angle * std::numbers::pi_v<float> / 180});
      features.descriptors.push_back(
          RootSift(std::span<const float, 128>(histograms.ptr<float>(index), 128)));
    }
    return features;
  } catch (const std::exception& exception) {
    return MakeError(ErrorCode::kUnavailable, "OpenCV: {}", exception.what());
  }
}

}  // namespace waymark::mapping

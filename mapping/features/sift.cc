// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "mapping/features/features.h"
#include "mapping/features/internal/opencv_setup.h"

namespace waymark::mapping {
namespace {

// OpenCV doubles the image before it builds its pyramid and takes pixel 2i of the doubled image for
// pixel i, where it lies at i - 0.25. With the half pixel of our convention that leaves +0.25,
// which the tests confirm on blobs of known centre.
constexpr float kCornerFromOpenCv_px = 0.25F;

cv::Mat Smooth(const cv::Mat& image, double sigma_px) {
  if (sigma_px == 0) return image;
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, cv::Size(), sigma_px);
  return smooth;
}

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

/// The strongest first. Response ties are broken by place, so that the order is total but for
/// keypoints that are equal in everything.
std::vector<int> OrderByStrength(const std::vector<cv::KeyPoint>& keypoints, int max_features) {
  std::vector<int> order(keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int index) {
    const cv::KeyPoint& keypoint = keypoints[index];
    return std::tuple(-keypoint.response, keypoint.pt.y, keypoint.pt.x, keypoint.size,
                      keypoint.angle, index);
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  if (order.size() > static_cast<std::size_t>(max_features)) order.resize(max_features);
  return order;
}

/// Source: Arandjelovic & Zisserman 2012, section 3: L1-normalise, then the square root.
Descriptor RootSift(std::span<const float, 128> histogram) {
  const float sum = std::accumulate(histogram.begin(), histogram.end(), 0.0F);
  const float scale = sum > 0 ? 512.0F / std::sqrt(sum) : 0.0F;
  Descriptor descriptor;
  std::transform(histogram.begin(), histogram.end(), descriptor.begin(), [&](float value) {
    return static_cast<std::uint8_t>(std::min(255.0F, std::sqrt(value) * scale + 0.5F));
  });
  return descriptor;
}

ImageFeatures Convert(const std::vector<cv::KeyPoint>& keypoints, const cv::Mat& histograms,
                      int max_features, float scale_x, float scale_y) {
  ImageFeatures features;
  const std::vector<int> order = OrderByStrength(keypoints, max_features);
  features.keypoints.reserve(order.size());
  features.descriptors.reserve(order.size());
  for (const int index : order) {
    const cv::KeyPoint& keypoint = keypoints[index];
    features.keypoints.push_back({.x_px = (keypoint.pt.x + kCornerFromOpenCv_px) * scale_x,
                                  .y_px = (keypoint.pt.y + kCornerFromOpenCv_px) * scale_y,
                                  .scale_px = keypoint.size * std::sqrt(scale_x * scale_y),
                                  .angle_rad = keypoint.angle * std::numbers::pi_v<float> / 180});
    features.descriptors.push_back(
        RootSift(std::span<const float, 128>(histograms.ptr<float>(index), 128)));
  }
  return features;
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
  internal::SetUpOpenCv();
  try {
    const cv::Mat full(image.height_px, image.width_px, CV_8UC1,
                       const_cast<std::uint8_t*>(image.pixels.data()));  // only read
    const cv::Mat reduced =
        ReduceToSide(Smooth(full, options.smoothing_px), options.max_image_side_px);
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat histograms;
    // With a limit, descriptors are computed only for the keypoints kept and their ties.
    cv::SIFT::create(options.max_features, 3, options.contrast_threshold)
        ->detectAndCompute(reduced, cv::noArray(), keypoints, histograms);
    return Convert(keypoints, histograms, options.max_features,
                   static_cast<float>(full.cols) / static_cast<float>(reduced.cols),
                   static_cast<float>(full.rows) / static_cast<float>(reduced.rows));
  } catch (const std::exception& exception) {
    return MakeError(ErrorCode::kUnavailable, "features of an image of {} x {}: {}", image.width_px,
                     image.height_px, exception.what());
  }
}

}  // namespace waymark::mapping

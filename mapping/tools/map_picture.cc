// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/map_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace waymark::mapping {
namespace {

constexpr int kMarginPx = 40;
constexpr int kFooterPx = 50;
constexpr int kFractionBits = 4;
const cv::Scalar kInk(60, 60, 60);

/// Paper over the map's plane.
class Sheet {
 public:
  Sheet(const Eigen::AlignedBox2d& box, int side_px)
      : corner_(box.min().x(), box.max().y()),
        scale_((side_px - 2 * kMarginPx) / std::max(1.0, box.sizes().maxCoeff())) {
    const Eigen::Vector2d size = scale_ * box.sizes();
    image_ = cv::Mat(static_cast<int>(size.y()) + 2 * kMarginPx + kFooterPx,
                     std::max(static_cast<int>(size.x()) + 2 * kMarginPx, 500), CV_8UC3,
                     cv::Scalar(255, 255, 255));
  }

  void Speck(const Eigen::Vector3d& x) {
    const cv::Point at = At(x, 0);
    if (!cv::Rect({0, 0}, image_.size()).contains(at)) return;
    auto& pixel = image_.at<cv::Vec3b>(at);
    for (int i = 0; i < 3; ++i) pixel[i] = static_cast<uchar>(std::max(150, pixel[i] - 25));
  }
  void Disc(const Eigen::Vector3d& x, double radius_px, int width_px, const cv::Scalar& colour) {
    cv::circle(image_, At(x, kFractionBits), static_cast<int>(radius_px * (1 << kFractionBits)),
               colour, width_px, cv::LINE_AA, kFractionBits);
  }
  /// The longest of 1, 2, 5, 10, … metres that takes less than a third of the width.
  void Bar() {
    double length_m = 1;
    for (const double factor : {2.0, 2.5, 2.0, 2.0, 2.5, 2.0, 2.0, 2.5, 2.0, 2.0, 2.5, 2.0}) {
      if (length_m * factor * scale_ < image_.cols / 3.0) length_m *= factor;
    }
    const cv::Point from(kMarginPx, image_.rows - kFooterPx / 2);
    const cv::Point to = from + cv::Point(static_cast<int>(length_m * scale_), 0);
    cv::line(image_, from, to, kInk, 3, cv::LINE_AA);
    cv::putText(image_, fmt::format("{} m", length_m), to + cv::Point(10, 5),
                cv::FONT_HERSHEY_SIMPLEX, 0.6, kInk, 1, cv::LINE_AA);
  }
  double pixels_per_metre() const { return scale_; }
  const cv::Mat& image() const { return image_; }

 private:
  cv::Point At(const Eigen::Vector3d& x, int fraction_bits) const {
    const double unit = 1 << fraction_bits;
    return {static_cast<int>(std::lround(unit * (kMarginPx + scale_ * (x.x() - corner_.x())))),
            static_cast<int>(std::lround(unit * (kMarginPx + scale_ * (corner_.y() - x.y()))))};
  }

  Eigen::Vector2d corner_;  ///< north-west
  double scale_;
  cv::Mat image_;
};

/// Colours far from each other for neighbours in the list: hues a golden angle apart.
cv::Scalar ColourOf(std::size_t index) {
  const auto hue = static_cast<uchar>(std::fmod(111.246 / 2 * static_cast<double>(index), 180));
  cv::Mat3b pixel(1, 1, cv::Vec3b(hue, 220, static_cast<uchar>(index % 2 == 0 ? 200 : 150)));
  cv::cvtColor(pixel, pixel, cv::COLOR_HSV2BGR);
  return cv::Scalar(pixel(0, 0));
}

Eigen::AlignedBox2d Bounds(const std::vector<DrawnSubmap>& submaps) {
  Eigen::AlignedBox2d box;
  for (const DrawnSubmap& submap : submaps) {
    const Eigen::Vector2d centre = submap.centre.coordinates().head<2>();
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(submap.radius_m + 5);
    box.extend(Eigen::AlignedBox2d(centre - reach, centre + reach));
  }
  return box;
}

}  // namespace

Result<std::vector<std::uint8_t>> DrawMap(const std::vector<DrawnSubmap>& submaps, int side_px) {
  CHECK(!submaps.empty(), "a release has submaps");
  Sheet sheet(Bounds(submaps), side_px);
  for (const DrawnSubmap& drawn : submaps) {
    for (std::size_t i = 0; i < drawn.submap.landmark_count(); ++i) {
      sheet.Speck((drawn.submap.map_from_submap() * drawn.submap.Landmark(i)).coordinates());
    }
  }
  for (std::size_t s = 0; s < submaps.size(); ++s) {
    const auto& [submap, centre, radius_m] = submaps[s];
    const cv::Scalar colour = ColourOf(s);
    sheet.Disc(centre.coordinates(), radius_m * sheet.pixels_per_metre(), 1, colour);
    for (const SubmapImage& image : submap.images()) {
      const auto pose = CarryPose(submap.map_from_submap(), image.submap_from_camera);
      if (image.is_borrowed) {
        sheet.Disc(pose.translation(), 3 + static_cast<double>(s % 4), 1, colour);
      } else {
        sheet.Disc(pose.translation(), 2.5, cv::FILLED, colour);
      }
    }
  }
  sheet.Bar();
  std::vector<std::uint8_t> png;
  if (cv::imencode(".png", sheet.image(), png)) return png;
  return MakeError(ErrorCode::kUnavailable, "the picture of {} submaps cannot be encoded",
                   submaps.size());
}

}  // namespace waymark::mapping

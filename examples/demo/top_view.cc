// SPDX-License-Identifier: Apache-2.0
#include "examples/demo/top_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "mapping/base/file.h"

namespace waymark::demo {
namespace {

constexpr int kLongSidePx = 1400;
constexpr int kMarginPx = 40;
constexpr int kLegendPx = 150;

const cv::Scalar kInk(60, 60, 60);
const cv::Scalar kVehicleColour(0, 160, 255);
const std::vector<cv::Scalar> kPhoneColours{
    {40, 40, 220}, {200, 110, 20}, {30, 150, 30}, {180, 30, 160}, {20, 150, 200}};

const cv::Scalar& PhoneColour(std::size_t index) {
  return kPhoneColours[index % kPhoneColours.size()];
}

/// A sheet of paper over the true world. Lengths are antialiased with 4 fractional bits.
class Sheet {
 public:
  Sheet(const Eigen::Vector2d& low, const Eigen::Vector2d& high)
      : low_(low), high_(high), scale_((kLongSidePx - 2 * kMarginPx) / (high - low).maxCoeff()) {
    const Eigen::Vector2d size = scale_ * (high - low);
    image_ = cv::Mat(static_cast<int>(size.y()) + 2 * kMarginPx + kLegendPx,
                     std::max(static_cast<int>(size.x()) + 2 * kMarginPx, 900), CV_8UC3,
                     cv::Scalar(255, 255, 255));
  }

  cv::Point Place(const Eigen::Vector3d& x) const {
    return {static_cast<int>(16 * (kMarginPx + scale_ * (x.x() - low_.x()))),
            static_cast<int>(16 * (kMarginPx + scale_ * (high_.y() - x.y())))};
  }
  void Dot(const Eigen::Vector3d& x, int radius_px, const cv::Scalar& colour) {
    cv::circle(image_, Place(x), 16 * radius_px, colour, cv::FILLED, cv::LINE_AA, 4);
  }
  void Line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, int width_px,
            const cv::Scalar& colour) {
    cv::line(image_, Place(a), Place(b), colour, width_px, cv::LINE_AA, 4);
  }
  void Pixel(const Eigen::Vector3d& x, const cv::Scalar& colour) {
    const cv::Point at = Place(x) / 16;
    if (!cv::Rect(0, 0, image_.cols, image_.rows - kLegendPx).contains(at)) return;
    image_.at<cv::Vec3b>(at) =
        cv::Vec3b(cv::saturate_cast<uchar>(colour[0]), cv::saturate_cast<uchar>(colour[1]),
                  cv::saturate_cast<uchar>(colour[2]));
  }
  void Text(const cv::Point& at, const std::string& text, const cv::Scalar& colour) {
    cv::putText(image_, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, colour, 1, cv::LINE_AA);
  }
  void Swatch(const cv::Point& at, int width_px, const cv::Scalar& colour) {
    cv::line(image_, at, at + cv::Point(28, 0), colour, width_px, cv::LINE_AA);
  }
  double pixels_per_metre() const { return scale_; }
  cv::Mat& image() { return image_; }

 private:
  Eigen::Vector2d low_, high_;
  double scale_;
  cv::Mat image_;
};

/// What must be on the sheet: vehicles and phones with some street around them.
Sheet MakeSheet(const MapPicture& map, const MapAlignment& alignment,
                const std::vector<WalkedPhone>& phones) {
  Eigen::AlignedBox2d box;
  for (const auto& image : map.images) {
    box.extend((alignment.by_fit * image.map_from_camera).translation().head<2>().eval());
  }
  for (const auto& phone : phones) {
    for (const auto& [name, pose] : phone.truth) box.extend(pose.translation().head<2>().eval());
  }
  const Eigen::Vector2d street = Eigen::Vector2d::Constant(8);
  return {box.min() - street, box.max() + street};
}

void DrawMap(const MapPicture& map, const MapAlignment& alignment, Sheet& sheet) {
  for (const auto& landmark : map.landmarks) {
    const Eigen::Vector3d x = alignment.by_fit.rigid() * landmark.coordinates();
    const double height = std::clamp(x.z() / 12, 0.0, 1.0);  // dark on the ground, light above
    sheet.Pixel(x, cv::Scalar(150 + 50 * height, 120 + 80 * height, 90 + 100 * height));
  }
  for (const auto& image : map.images) {
    sheet.Dot((alignment.by_fit * image.map_from_camera).translation(), 3, kVehicleColour);
  }
}

void DrawTrack(const WalkedPhone& phone, const MapAlignment& alignment, const cv::Scalar& colour,
               Sheet& sheet) {
  const Rigid3* last_truth = nullptr;
  std::optional<Eigen::Vector3d> last_belief;
  for (const auto& point : phone.result.track) {
    const auto truth = phone.truth.find(point.image);
    if (truth == phone.truth.end()) continue;
    if (last_truth) sheet.Line(last_truth->translation(), truth->second.translation(), 1, kInk);
    last_truth = &truth->second;
    if (!point.map_from_camera) continue;
    const Eigen::Vector3d belief = (alignment.by_fit * *point.map_from_camera).translation();
    if (last_belief) sheet.Line(*last_belief, belief, 2, colour);
    sheet.Dot(belief, 3, colour);
    last_belief = belief;
  }
}

void DrawAnchors(const std::vector<AnchorFigures>& anchors, Sheet& sheet) {
  for (const auto& anchor : anchors) {
    for (std::size_t i = 0; i < anchor.views.size(); ++i) {
      if (!anchor.views[i].shown_in_world) continue;
      const cv::Point at = sheet.Place(*anchor.views[i].shown_in_world) / 16;
      cv::drawMarker(sheet.image(), at, PhoneColour(i), cv::MARKER_TILTED_CROSS,
                     18 + 6 * static_cast<int>(i), 2, cv::LINE_AA);
    }
  }
}

void DrawLegend(const std::vector<WalkedPhone>& phones, Sheet& sheet) {
  int y = sheet.image().rows - kLegendPx + 25;
  const int bar = static_cast<int>(10 * sheet.pixels_per_metre());
  cv::line(sheet.image(), {kMarginPx, y}, {kMarginPx + bar, y}, kInk, 3);
  sheet.Text({kMarginPx + bar + 8, y + 5}, "10 m", kInk);
  y += 28;
  sheet.Swatch({kMarginPx, y}, 6, kVehicleColour);
  sheet.Text({kMarginPx + 36, y + 5}, "vehicle cameras", kInk);
  sheet.Swatch({kMarginPx + 200, y}, 6, cv::Scalar(175, 160, 140));
  sheet.Text({kMarginPx + 236, y + 5}, "map points", kInk);
  sheet.Swatch({kMarginPx + 380, y}, 1, kInk);
  sheet.Text({kMarginPx + 416, y + 5}, "where phones truly walked", kInk);
  sheet.Text({kMarginPx + 660, y + 5}, "x  the anchor, as each phone shows it", kInk);
  y += 28;
  int x = kMarginPx;
  for (std::size_t i = 0; i < phones.size(); ++i) {
    sheet.Swatch({x, y}, 4, PhoneColour(i));
    sheet.Text({x + 36, y + 5}, phones[i].result.name, kInk);
    x += 200;
  }
}

}  // namespace

Result<void> DrawTopView(const MapPicture& map, const MapAlignment& alignment,
                         const std::vector<WalkedPhone>& phones,
                         const std::vector<AnchorFigures>& anchors,
                         const std::filesystem::path& png) {
  Sheet sheet = MakeSheet(map, alignment, phones);
  DrawMap(map, alignment, sheet);
  for (std::size_t i = 0; i < phones.size(); ++i) {
    DrawTrack(phones[i], alignment, PhoneColour(i), sheet);
  }
  DrawAnchors(anchors, sheet);
  DrawLegend(phones, sheet);
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", sheet.image(), bytes)) {
    return MakeError(ErrorCode::kUnavailable, "{}: the picture cannot be encoded", png.string());
  }
  return StoreFileAtomically(png, bytes);
}

}  // namespace waymark::demo

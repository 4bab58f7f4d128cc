// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace waymark::evaluation {

/// A drawing as an SVG document; pixels, y down.
class Svg {
 public:
  Svg(int width_px, int height_px) : width_px_(width_px), height_px_(height_px) {}

  /// Colours as CSS has them.
  void Line(const std::vector<Eigen::Vector2d>& points, std::string_view colour, double width_px);
  void Dot(const Eigen::Vector2d& at, double radius_px, std::string_view colour);
  void Box(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, std::string_view colour);
  /// `anchor`: start, middle or end of the text lies there.
  void Text(const Eigen::Vector2d& at, const std::string& text, std::string_view anchor = "start",
            int size_px = 14);

  std::string Document() const;

 private:
  int width_px_, height_px_;
  std::string body_;
};

/// How values spread: bars of `width` from 0, the last one holds all that is more.
std::string DrawHistogram(std::span<const double> values, double width, int bars,
                          const std::string& title, const std::string& unit);

}  // namespace waymark::evaluation

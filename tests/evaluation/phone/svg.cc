// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/phone/svg.h"

#include <fmt/format.h>

#include <algorithm>

namespace waymark::evaluation {

void Svg::Line(const std::vector<Eigen::Vector2d>& points, std::string_view colour,
               double width_px) {
  if (points.size() < 2) return;
  body_ += fmt::format(R"(<polyline fill="none" stroke="{}" stroke-width="{}" points=")", colour,
                       width_px);
  for (const auto& point : points) body_ += fmt::format("{:.1f},{:.1f} ", point.x(), point.y());
  body_ += "\"/>\n";
}

void Svg::Dot(const Eigen::Vector2d& at, double radius_px, std::string_view colour) {
  body_ += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{}" fill="{}"/>)"
                       "\n",
                       at.x(), at.y(), radius_px, colour);
}

void Svg::Box(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, std::string_view colour) {
  body_ += fmt::format(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}"/>)"
                       "\n",
                       corner.x(), corner.y(), size.x(), size.y(), colour);
}

void Svg::Text(const Eigen::Vector2d& at, const std::string& text, std::string_view anchor,
               int size_px) {
  body_ += fmt::format(
      R"(<text x="{:.1f}" y="{:.1f}" font-family="sans-serif" font-size="{}" text-anchor="{}">{}</text>)"
      "\n",
      at.x(), at.y(), size_px, anchor, text);
}

std::string Svg::Document() const {
  return fmt::format(
             R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" viewBox="0 0 {0} {1}">)"
             "\n"
             R"(<rect width="100%" height="100%" fill="white"/>)"
             "\n",
             width_px_, height_px_) +
         body_ + "</svg>\n";
}

std::string DrawHistogram(std::span<const double> values, double width, int bars,
                          const std::string& title, const std::string& unit) {
  constexpr double kLeft = 60, kTop = 50, kHeight = 280, kBar = 32;
  std::vector<int> counts(static_cast<std::size_t>(bars), 0);
  for (const double value : values) {
    ++counts[static_cast<std::size_t>(std::clamp<double>(value / width, 0, bars - 1))];
  }
  const int most = std::max(1, *std::max_element(counts.begin(), counts.end()));
  Svg svg(static_cast<int>(2 * kLeft + bars * kBar), static_cast<int>(kTop + kHeight + 70));
  svg.Text({kLeft, 28}, title, "start", 16);
  for (int i = 0; i < bars; ++i) {
    const double x = kLeft + i * kBar;
    const int count = counts[static_cast<std::size_t>(i)];
    const double height = kHeight * count / most;
    svg.Box({x + 1, kTop + kHeight - height}, {kBar - 2, height}, "#3b6ea5");
    if (count > 0) {
      svg.Text({x + kBar / 2, kTop + kHeight - height - 4}, fmt::format("{}", count), "middle", 11);
    }
    if (i % 2 == 0) {
      svg.Text({x, kTop + kHeight + 18}, fmt::format("{:.4g}", i * width), "middle", 12);
    }
  }
  svg.Line({{kLeft, kTop + kHeight}, {kLeft + bars * kBar, kTop + kHeight}}, "#444", 1);
  svg.Text({kLeft + bars * kBar / 2, kTop + kHeight + 45},
           fmt::format("{} (the last bar: all that is more)", unit), "middle");
  return svg.Document();
}

}  // namespace waymark::evaluation

// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/rain.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace waymark::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr double kReferenceWidth = 640;  // sizes below are in pixels of such an image

/// An image by place; outside it repeats its edge.
class Plane {
 public:
  explicit Plane(Radiance& image) : image_(image) {}

  Eigen::Map<Vector3f> At(double x, double y) {
    const int column = std::clamp(static_cast<int>(x), 0, image_.width_px - 1);
    const int row = std::clamp(static_cast<int>(y), 0, image_.height_px - 1);
    return Eigen::Map<Vector3f>(&image_.values[3 * (static_cast<std::size_t>(row) *
                                                        static_cast<std::size_t>(image_.width_px) +
                                                    static_cast<std::size_t>(column))]);
  }
  bool Contains(double x, double y) const {
    return x >= 0 && y >= 0 && x < image_.width_px && y < image_.height_px;
  }

 private:
  Radiance& image_;
};

void AddDrop(const Vector2d& centre, double radius, Radiance& source, Radiance& target) {
  constexpr double kShrink = 2.5;
  Plane behind(source);
  Plane front(target);
  for (double y = -radius; y <= radius; ++y) {
    for (double x = -radius; x <= radius; ++x) {
      const double share = std::hypot(x, y) / radius;
      if (share >= 1 || !front.Contains(centre.x() + x, centre.y() + y)) continue;
      Vector3f seen = Vector3f::Zero();
      for (const double dy : {-0.6, 0.0, 0.6}) {
        for (const double dx : {-0.6, 0.0, 0.6}) {
          seen += behind.At(centre.x() - kShrink * x + dx * radius,
                            centre.y() - kShrink * y + dy * radius) /
                  9;
        }
      }
      auto pixel = front.At(centre.x() + x, centre.y() + y);
      const auto opacity = static_cast<float>(std::min(1.0, 3 * (1 - share)));
      pixel += opacity * (seen - pixel);
    }
  }
}

void AddStreak(double scale, float level, Random& random, Radiance& image) {
  Plane plane(image);
  const double length = scale * random.Uniform(15, 60);
  const double slant = random.Uniform(0.02, 0.12);
  const float opacity = random.UniformFloat(0.08F, 0.3F);
  const Vector2d top(random.Uniform(-10, image.width_px), random.Uniform(-20, image.height_px));
  for (double along = 0; along < length; ++along) {
    const double x = top.x() + slant * along;
    if (!plane.Contains(x, top.y() + along)) continue;
    auto pixel = plane.At(x, top.y() + along);
    pixel += opacity * (Vector3f::Constant(level) - pixel);
  }
}

}  // namespace

void AddRain(float rain, Random random, Radiance& image) {
  if (rain <= 0 || image.values.empty()) return;
  const double scale = image.width_px / kReferenceWidth;
  float sum = 0;
  for (const float value : image.values) sum += value / static_cast<float>(image.values.size());
  const int streaks = static_cast<int>(150 * rain);
  for (int i = 0; i < streaks; ++i) AddStreak(scale, 1.5F * sum, random, image);
  Radiance behind = image;
  const int drops = static_cast<int>(rain * static_cast<float>(random.Integer(3, 10)));
  for (int i = 0; i < drops; ++i) {
    const Vector2d centre(random.Uniform(0, image.width_px), random.Uniform(0, image.height_px));
    AddDrop(centre, scale * random.Uniform(6, 24), behind, image);
  }
}

}  // namespace waymark::simulator

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "mapping/features/features.h"
#include "mapping/submap/submap_model.h"
#include "tests/support/random_geometry.h"

/// One picture, and a map of what it shows.
namespace waymark::session::support {

inline constexpr int kPictureWidth = 320, kPictureHeight = 240;

/// Blots of all sizes: something to find everywhere.
inline std::vector<std::uint8_t> Picture() {
  waymark::support::RandomGeometry random(1);
  std::vector<double> sums(kPictureWidth * kPictureHeight, 128);
  for (int blot = 0; blot < 400; ++blot) {
    const double x = random.Uniform(0, kPictureWidth), y = random.Uniform(0, kPictureHeight);
    const double sigma = random.Uniform(1.5, 6), height = random.Normal(50);
    for (int v = 0; v < kPictureHeight; ++v) {
      for (int u = 0; u < kPictureWidth; ++u) {
        const double squares = (u - x) * (u - x) + (v - y) * (v - y);
        sums[static_cast<std::size_t>(v * kPictureWidth + u)] +=
            height * std::exp(-0.5 * squares / (sigma * sigma));
      }
    }
  }
  std::vector<std::uint8_t> pixels;
  for (const double sum : sums) {
    pixels.push_back(static_cast<std::uint8_t>(std::clamp(sum, 0.0, 255.0)));
  }
  return pixels;
}

inline CameraModel TestCamera() {
  const std::array<double, 4> parameters{300, 300, 160, 120};
  return *CameraModel::Create(CameraKind::kPinhole, kPictureWidth, kPictureHeight, parameters);
}

/// A map of what one picture shows, at random distances.
inline mapping::SubmapModel MapOf(const mapping::ImageFeatures& features) {
  waymark::support::RandomGeometry random(2);
  mapping::SubmapModel model;
  model.origin = {Angle::Degrees(37.77), Angle::Degrees(-122.42), 10};
  model.cameras.push_back(TestCamera());
  for (const std::string name : {"a.jpg", "b.jpg"}) {
    model.images.push_back({.experience = ExperienceId("drive"),
                            .name = name,
                            .camera = 0,
                            .submap_from_camera = Transform<Submap, Camera>(Rigid3()),
                            .gnss = std::nullopt});
  }
  for (std::uint32_t i = 0; i < features.keypoints.size(); ++i) {
    const mapping::Keypoint& at = features.keypoints[i];
    model.landmarks.emplace_back(
        Eigen::Vector3d(random.Uniform(5, 30) * TestCamera().Unproject({at.x_px, at.y_px})));
    for (std::uint32_t image = 0; image < 2; ++image) {
      model.observations.push_back({i, image, at.x_px, at.y_px, features.descriptors[i]});
    }
  }
  return model;
}

}  // namespace waymark::session::support

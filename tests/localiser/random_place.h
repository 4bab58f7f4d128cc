// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "mapping/features/features.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/submap/submap_model.h"
#include "tests/support/random_geometry.h"

namespace waymark::localiser {

inline CameraModel TestCamera() {
  return *CameraModel::Create(CameraKind::kPinhole, 640, 480,
                              std::vector<double>{520, 520, 320, 240});
}

/// A street front of random landmarks, each seen by several map images with slightly different
/// descriptors, and photos of it.
class RandomPlace {
 public:
  struct Size {
    int landmarks = 600;
    int sightings = 3;  ///< per landmark
    double width_m = 30;
  };

  RandomPlace(const Size& size, std::uint64_t seed) : size_(size), random_(seed), engine_(seed) {
    for (int i = 0; i < size.landmarks; ++i) {
      landmarks_.emplace_back(random_.Uniform(-size.width_m / 2, size.width_m / 2),
                              random_.Uniform(10, 16), random_.Uniform(-1, 7));
      appearances_.push_back(RandomDescriptor());
    }
  }
  explicit RandomPlace(std::uint64_t seed) : RandomPlace(Size{}, seed) {}

  const std::vector<Eigen::Vector3d>& landmarks() const { return landmarks_; }

  /// Where a person stands who looks at the front (north, +y), camera axes.
  Rigid3 Viewpoint(double east_m, double north_m = 0) const {
    const Eigen::Quaterniond looks_north(RotationFromVector({-M_PI / 2, 0, 0}));
    return {looks_north, {east_m, north_m, 1.6}};
  }

  /// What a camera sees there: visible landmarks with noise, and clutter that is in no map.
  mapping::ImageFeatures Photo(const Rigid3& place_from_camera, int clutter,
                               double noise_px = 0.5) {
    const CameraModel camera = TestCamera();
    mapping::ImageFeatures features;
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      const auto pixel_px = camera.Project(place_from_camera.Inverse() * landmarks_[i]);
      if (!pixel_px) continue;
      const Eigen::Vector2d seen_px =
          *pixel_px + Eigen::Vector2d(random_.Normal(noise_px), random_.Normal(noise_px));
      if (camera.Contains(seen_px)) Append(seen_px, Vary(appearances_[i]), features);
    }
    for (int i = 0; i < clutter; ++i) {
      Append({random_.Uniform(0, 639), random_.Uniform(0, 479)}, RandomDescriptor(), features);
    }
    return features;
  }

  /// The place as a submap, in the place's own frame.
  mapping::SubmapModel Model() {
    mapping::SubmapModel model;
    model.origin = {Angle::Degrees(37.77), Angle::Degrees(-122.42), 10};
    model.cameras.push_back(TestCamera());
    for (int s = 0; s < size_.sightings; ++s) {
      const Rigid3 viewpoint = Viewpoint((s - 1) * size_.width_m / 4);
      model.images.push_back({.experience = ExperienceId("drive"),
                              .name = "image" + std::to_string(s) + ".jpg",
                              .camera = 0,
                              .submap_from_camera = Transform<Submap, Camera>(viewpoint),
                              .gnss = std::nullopt,
                              .gnss_sigma_m = 1,
                              .is_borrowed = false});
    }
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      model.landmarks.emplace_back(landmarks_[i]);
      for (int s = 0; s < size_.sightings; ++s) {
        model.observations.push_back({.landmark = static_cast<std::uint32_t>(i),
                                      .image = static_cast<std::uint32_t>(s),
                                      .x_px = 1,
                                      .y_px = 1,
                                      .descriptor = Vary(appearances_[i])});
      }
    }
    return model;
  }

  /// As RootSIFT's: on the sphere of radius 512, no component negative, many near zero.
  mapping::Descriptor RandomDescriptor() {
    std::gamma_distribution<double> component(0.5, 1);
    std::array<double, 128> values;
    for (double& value : values) value = std::sqrt(component(engine_));
    return Normalised(values);
  }

  /// The same thing from elsewhere: about 0.3 rad away.
  mapping::Descriptor Vary(const mapping::Descriptor& descriptor) {
    std::array<double, 128> values;
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = std::max(0.0, descriptor[i] + random_.Normal(14));
    }
    return Normalised(values);
  }

 private:
  static mapping::Descriptor Normalised(const std::array<double, 128>& values) {
    double squared = 0;
    for (const double value : values) squared += value * value;
    mapping::Descriptor descriptor;
    for (std::size_t i = 0; i < values.size(); ++i) {
      descriptor[i] = static_cast<std::uint8_t>(
          std::lround(std::min(255.0, 512 * values[i] / std::sqrt(squared))));
    }
    return descriptor;
  }
  static void Append(const Eigen::Vector2d& pixel_px, const mapping::Descriptor& descriptor,
                     mapping::ImageFeatures& features) {
    features.keypoints.push_back(
        {static_cast<float>(pixel_px.x()), static_cast<float>(pixel_px.y()), 4, 0});
    features.descriptors.push_back(descriptor);
  }

  Size size_;
  support::RandomGeometry random_;
  std::mt19937_64 engine_;
  std::vector<Eigen::Vector3d> landmarks_;
  std::vector<mapping::Descriptor> appearances_;
};

}  // namespace waymark::localiser

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

#include "mapping/submap/submap_model.h"
#include "tests/support/random_geometry.h"

namespace waymark::mapping {

/// A small submap with every optional part present somewhere and absent elsewhere.
inline SubmapModel ExampleSubmap(std::uint64_t seed = 1, std::uint32_t landmark_count = 5) {
  support::RandomGeometry random(seed);
  SubmapModel model;
  model.origin = {Angle::Degrees(37.7749), Angle::Degrees(-122.4194), 16.5};
  model.cameras = {
      CameraModel::Create(CameraKind::kPinhole, 640, 480, std::vector<double>{500, 501, 320, 240})
          .value(),
      CameraModel::Create(CameraKind::kOpenCv, 1920, 1080,
                          std::vector<double>{900, 901, 960, 540, -0.1, 0.02, 1e-3, -2e-3})
          .value()};
  for (std::uint32_t i = 0; i < 3; ++i) {
    const Rigid3 pose = random.Rigid();
    SubmapImage image{ExperienceId(i < 2 ? "morning" : "evening"),
                      "front/" + std::to_string(i) + ".jpg",
                      i % 2,
                      Transform<Submap, Camera>(pose),
                      std::nullopt,
                      2.5,
                      i == 2};
    if (i > 0) image.gnss = GeoPoint{Angle::Radians(0.65), Angle::Radians(-2.1), 12.25};
    model.images.push_back(image);
  }
  std::mt19937_64 engine(seed);
  for (std::uint32_t landmark = 0; landmark < landmark_count; ++landmark) {
    model.landmarks.emplace_back(random.Vector(50));
    for (std::uint32_t image = landmark % 2; image < 3; ++image) {
      LandmarkObservation observation{landmark, image, static_cast<float>(random.Uniform(0, 640)),
                                      static_cast<float>(random.Uniform(0, 480)), Descriptor{}};
      for (auto& value : observation.descriptor) value = static_cast<std::uint8_t>(engine());
      model.observations.push_back(observation);
    }
  }
  model.scale_sigma = 0.004;
  model.evidence = {.accepted = true,
                    .verdict = "consecutive rotations agree with the gyroscope",
                    .max_gyroscope_error_rad = 0.01,
                    .max_gravity_error_rad = 0.02,
                    .max_speed_mps = 13.5,
                    .mean_reprojection_px = 0.6};
  return model;
}

/// Expects two submaps to say the same.
inline void ExpectSameSubmap(const SubmapModel& a, const SubmapModel& b) {
  EXPECT_EQ(a.origin.latitude, b.origin.latitude);
  EXPECT_EQ(a.origin.longitude, b.origin.longitude);
  EXPECT_EQ(a.origin.ellipsoid_height_m, b.origin.ellipsoid_height_m);
  EXPECT_EQ(a.is_geo_aligned, b.is_geo_aligned);
  EXPECT_EQ(a.scale_sigma, b.scale_sigma);
  EXPECT_EQ(a.cameras, b.cameras);
  ASSERT_EQ(a.images.size(), b.images.size());
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    const SubmapImage& x = a.images[i];
    const SubmapImage& y = b.images[i];
    EXPECT_EQ(x.experience, y.experience);
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.camera, y.camera);
    EXPECT_EQ(x.submap_from_camera.translation(), y.submap_from_camera.translation());
    EXPECT_THAT(x.submap_from_camera.rigid(), support::Near(y.submap_from_camera.rigid()));
    ASSERT_EQ(x.gnss.has_value(), y.gnss.has_value());
    if (x.gnss) {
      EXPECT_EQ(x.gnss->latitude, y.gnss->latitude);
      EXPECT_EQ(x.gnss->longitude, y.gnss->longitude);
      EXPECT_EQ(x.gnss->ellipsoid_height_m, y.gnss->ellipsoid_height_m);
    }
    EXPECT_EQ(x.gnss_sigma_m, y.gnss_sigma_m);
    EXPECT_EQ(x.is_borrowed, y.is_borrowed);
  }
  ASSERT_EQ(a.landmarks.size(), b.landmarks.size());
  for (std::size_t i = 0; i < a.landmarks.size(); ++i) {
    EXPECT_EQ(a.landmarks[i].coordinates(), b.landmarks[i].coordinates());
  }
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (std::size_t i = 0; i < a.observations.size(); ++i) {
    const LandmarkObservation& x = a.observations[i];
    const LandmarkObservation& y = b.observations[i];
    EXPECT_EQ(std::tie(x.landmark, x.image, x.x_px, x.y_px, x.descriptor),
              std::tie(y.landmark, y.image, y.x_px, y.y_px, y.descriptor));
  }
  EXPECT_EQ(a.evidence.accepted, b.evidence.accepted);
  EXPECT_EQ(a.evidence.verdict, b.evidence.verdict);
  EXPECT_EQ(a.evidence.max_gyroscope_error_rad, b.evidence.max_gyroscope_error_rad);
  EXPECT_EQ(a.evidence.mean_reprojection_px, b.evidence.mean_reprojection_px);
}

}  // namespace waymark::mapping

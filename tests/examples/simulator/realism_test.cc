// SPDX-License-Identifier: Apache-2.0
// Features on simulated pictures must behave as on photographs: plenty, mostly matched rightly
// under the same light, fewer under another. Bounds leave room below what the README reports.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "examples/simulator/render/sensor.h"
#include "mapping/features/features.h"
#include "tests/examples/simulator/small_world.h"

namespace waymark::simulator {
namespace {

struct View {
  Rigid3 world_from_camera;
  mapping::ImageFeatures features;
};

struct MatchCount {
  int ratio_matches = 0;
  int correct = 0;
};

int SquaredDistance(const mapping::Descriptor& a, const mapping::Descriptor& b) {
  int sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const int difference = a[i] - b[i];
    sum += difference * difference;
  }
  return sum;
}

class RealismTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    CityOptions options;
    options.block_east_m = 30;
    options.block_north_m = 20;
    city_ = std::make_unique<City>(*BuildCity(options));
    camera_ = std::make_unique<CameraModel>(*MakeCamera({}));
  }
  static void TearDownTestSuite() { city_.reset(); }

  static Renderer Light(LightPreset preset) {
    return *Renderer::Create(*city_, MakeTraffic(*city_, {}, Random(2)),
                             MakeLighting(preset, Random(3)));
  }

  static View Look(const Renderer& renderer, double east_m, double yaw_deg) {
    View view{{BodyFromCameraRotation(Angle::Degrees(yaw_deg), Angle::Degrees(8)),
               Eigen::Vector3d(east_m, -7, 1.7)},
              {}};
    const ColourImage image =
        Expose(renderer.Render(ViewRays(*camera_), view.world_from_camera), renderer.lighting(), {},
               Random(static_cast<std::uint64_t>(100 * east_m + yaw_deg)));
    mapping::GrayImage gray{image.width_px, image.height_px, {}};
    for (std::size_t i = 0; i < image.values.size(); i += 3) {
      gray.pixels.push_back(static_cast<std::uint8_t>(
          (299 * image.values[i] + 587 * image.values[i + 1] + 114 * image.values[i + 2]) / 1000));
    }
    view.features = *mapping::ExtractFeatures(gray, {.max_features = 3000});
    return view;
  }

  /// Ratio test at 0.8; correct is within 4 px of the exact geometry.
  static MatchCount Match(const Renderer& renderer, const View& a, const View& b) {
    MatchCount count;
    for (std::size_t i = 0; i < a.features.keypoints.size(); ++i) {
      int best = std::numeric_limits<int>::max();
      int second = best;
      std::size_t match = 0;
      for (std::size_t j = 0; j < b.features.descriptors.size(); ++j) {
        const int distance = SquaredDistance(a.features.descriptors[i], b.features.descriptors[j]);
        if (distance < best) {
          second = best;
          best = distance;
          match = j;
        } else if (distance < second) {
          second = distance;
        }
      }
      if (best >= 0.64 * second) continue;
      ++count.ratio_matches;
      const mapping::Keypoint& from = a.features.keypoints[i];
      const auto point = renderer.FindSurface(
          a.world_from_camera.translation(),
          a.world_from_camera.rotation() * camera_->Unproject({from.x_px, from.y_px}));
      if (!point) continue;
      const auto pixel = camera_->Project(b.world_from_camera.Inverse() * *point);
      const mapping::Keypoint& to = b.features.keypoints[match];
      if (pixel && (*pixel - Eigen::Vector2d(to.x_px, to.y_px)).norm() < 4) ++count.correct;
    }
    return count;
  }

  static inline std::unique_ptr<City> city_;
  static inline std::unique_ptr<CameraModel> camera_;
};

TEST_F(RealismTest, FeaturesMatchAsOnPhotographs) {
  const Renderer day = Light(LightPreset::kDay);
  const View here = Look(day, 12, -80);
  const View beside = Look(day, 13.3, -90);
  EXPECT_GT(here.features.keypoints.size(), 1500U);
  EXPECT_GT(beside.features.keypoints.size(), 1500U);
  const MatchCount same = Match(day, here, beside);
  EXPECT_GT(same.correct, 250);
  EXPECT_GT(same.correct, 0.8 * same.ratio_matches);

  const MatchCount dull = Match(day, here, Look(Light(LightPreset::kOvercast), 13.3, -90));
  EXPECT_GT(dull.correct, 150);
  const MatchCount night = Match(day, here, Look(Light(LightPreset::kNight), 13.3, -90));
  EXPECT_LT(night.correct, same.correct / 2);
}

}  // namespace
}  // namespace waymark::simulator

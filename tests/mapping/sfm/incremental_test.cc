// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/incremental.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping/synthetic/capture.h"
#include "mapping/synthetic/walk.h"

namespace waymark::mapping {
namespace {

CameraModel TestCamera() {
  const std::array parameters{500.0, 320.0, 240.0, -0.05};
  return *CameraModel::Create(CameraKind::kSimpleRadial, 640, 480, parameters);
}

std::vector<Rigid3> LookAroundWalk(int count) {
  std::vector<Rigid3> walk;
  for (int i = 0; i < count; ++i) {
    const double t = i;
    walk.push_back(PlaceCamera({std::sin(0.4 * t), 2 + 0.8 * t, 1.7}, 0.35 * std::sin(0.7 * t),
                               0.05 * std::sin(t), 0.03 * std::cos(1.3 * t)));
  }
  return walk;
}

Result<Reconstruction> Reconstruct(const Capture& capture, std::span<const PairMatches> matches,
                                   const SfmOptions& options = {.parallelism = {1}},
                                   const SfmCamera* camera = nullptr) {
  const std::array cameras{camera != nullptr ? *camera : SfmCamera{capture.camera}};
  return ReconstructIncrementally(cameras, capture.Images(), matches, options);
}

struct Errors {
  std::size_t registered = 0;
  double mean_position_m = 0;  // after the best similarity
  double max_position_m = 0;
  double mean_absolute_m = 0;  // as is
  double max_rotation_rad = 0;
};

Errors Compare(const Reconstruction& result, const Capture& capture) {
  std::vector<Eigen::Vector3d> from;
  std::vector<Eigen::Vector3d> to;
  for (std::size_t i = 0; i < result.images.size(); ++i) {
    if (!result.images[i].submap_from_camera) continue;
    from.push_back(result.images[i].submap_from_camera->translation());
    to.push_back(capture.world_from_camera[i].translation());
  }
  Errors errors{.registered = from.size()};
  const auto sim = EstimateSimilarity(from, to);
  const auto count = static_cast<double>(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    errors.mean_absolute_m += (from[i] - to[i]).norm() / count;
    if (!sim) continue;
    const double error = (*sim * from[i] - to[i]).norm();
    errors.mean_position_m += error / count;
    errors.max_position_m = std::max(errors.max_position_m, error);
  }
  for (std::size_t i = 0; sim && i < result.images.size(); ++i) {
    if (!result.images[i].submap_from_camera) continue;
    errors.max_rotation_rad =
        std::max(errors.max_rotation_rad,
                 AngleBetween(sim->rotation() * result.images[i].submap_from_camera->rotation(),
                              capture.world_from_camera[i].rotation())
                     .radians());
  }
  return errors;
}

TEST(Incremental, IsExactForExactFeatures) {
  const Capture capture = CaptureWalk(MakeStreet({}), TestCamera(), LookAroundWalk(12), {});
  const auto result = Reconstruct(capture, MatchCapture(capture, 30, {}));
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  const Errors errors = Compare(*result, capture);
  EXPECT_EQ(errors.registered, 12U);
  EXPECT_LT(errors.max_position_m, 1e-4);  // keypoints are single precision
  EXPECT_LT(errors.max_rotation_rad, 1e-5);
  EXPECT_LT(result->mean_reprojection_px, 1e-3);
  EXPECT_FALSE(result->is_geo_aligned);
}

TEST(Incremental, WithstandsNoiseAndOutliers) {
  const CaptureOptions options{.pixel_sigma_px = 0.7, .outlier_share = 0.3, .gnss_sigma_m = 0.5};
  const Capture capture = CaptureWalk(MakeStreet({}), TestCamera(), LookAroundWalk(30), options);
  const auto result = Reconstruct(capture, MatchCapture(capture, 30, options));
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  const Errors errors = Compare(*result, capture);
  EXPECT_EQ(errors.registered, 30U);
  EXPECT_LT(errors.mean_position_m, 0.05);
  EXPECT_TRUE(result->is_geo_aligned);
  EXPECT_LT(errors.mean_absolute_m, 0.4);
}

}  // namespace
}  // namespace waymark::mapping

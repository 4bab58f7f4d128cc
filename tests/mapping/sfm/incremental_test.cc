// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/incremental.h"

#include <gmock/gmock.h>

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
  const Capture capture =
      CaptureWalk(MakeStreet({.points = 2000}), TestCamera(), LookAroundWalk(20), options);
  const auto result = Reconstruct(capture, MatchCapture(capture, 40, options));
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  const Errors errors = Compare(*result, capture);
  EXPECT_EQ(errors.registered, 20U);
  EXPECT_LT(errors.mean_position_m, 0.05);
  EXPECT_TRUE(result->is_geo_aligned);
  EXPECT_LT(errors.mean_absolute_m, 0.5);
  for (const ReconstructedPoint& point : result->points) {
    EXPECT_GE(point.track.size(), 2U);
    EXPECT_TRUE(std::is_sorted(
        point.track.begin(), point.track.end(),
        [](const TrackElement& a, const TrackElement& b) { return a.image < b.image; }));
  }
}

TEST(Incremental, FindsAnUnknownFocalLength) {
  const CaptureOptions options{.pixel_sigma_px = 0.5};
  const Capture capture =
      CaptureWalk(MakeStreet({.points = 2500}), TestCamera(), LookAroundWalk(20), options);
  const std::array guess{500 * 1.25, 320.0, 240.0, 0.0};
  const SfmCamera camera{*CameraModel::Create(CameraKind::kSimpleRadial, 640, 480, guess), false};
  const auto result =
      Reconstruct(capture, MatchCapture(capture, 40, options), {.parallelism = {1}}, &camera);
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  EXPECT_EQ(Compare(*result, capture).registered, 20U);
  EXPECT_NEAR(result->cameras[0].FocalX(), 500, 5);
  EXPECT_NEAR(result->cameras[0].parameters()[3], -0.05, 0.01);
}

TEST(Incremental, ReconstructsAPlane) {
  const CaptureOptions options{.pixel_sigma_px = 0.3, .gnss_sigma_m = 0.2};
  std::vector<Rigid3> walk;
  for (int i = 0; i < 10; ++i) {
    walk.push_back(PlaceCamera({1.2 * i - 6, -9 + 0.4 * (i % 3), 1.7}, 0.3 - 0.06 * i, 0.1));
  }
  const Capture capture = CaptureWalk(MakeFacade(30, 10, 800, 2), TestCamera(), walk, options);
  const auto result = Reconstruct(capture, MatchCapture(capture, 40, options));
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  const Errors errors = Compare(*result, capture);
  EXPECT_EQ(errors.registered, 10U);
  EXPECT_LT(errors.mean_position_m, 0.1);
}

TEST(Incremental, SaysThatPureRotationHasNoDepth) {
  const CaptureOptions options{.pixel_sigma_px = 0.5};
  const Capture capture = CaptureWalk(MakeCourtyard(20, 8, 1000, 1), TestCamera(),
                                      TurnInPlace({0, 0, 1.7}, 0.1, 8), options);
  const auto result = Reconstruct(capture, MatchCapture(capture, 40, options));
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(result.error().message, testing::HasSubstr("enough depth"));
}

TEST(Incremental, KeepsTheLargestOfSeparateGroupsAndNamesTheOthers) {
  std::vector<Rigid3> walk = LookAroundWalk(8);
  for (int i = 0; i < 5; ++i) {  // turned around: sees the other end
    walk.push_back(PlaceCamera({0.5 * std::sin(2.0 * i), 50 - 1.0 * i, 1.7}, 3.14 + 0.1 * i));
  }
  walk.push_back(PlaceCamera({0, 30, 200}, 0, 1.5));  // sees nothing
  const CaptureOptions options{.pixel_sigma_px = 0.3, .max_range_m = 18};
  const Capture capture = CaptureWalk(MakeStreet({.points = 4000}), TestCamera(), walk, options);
  const auto result = Reconstruct(capture, MatchCapture(capture, 15, options));
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  EXPECT_EQ(Compare(*result, capture).registered, 8U);
  EXPECT_THAT(result->images[9].exclusion, testing::HasSubstr("another group of 5 images"));
  EXPECT_THAT(result->images[13].exclusion, testing::HasSubstr("0 matches to the nearest image"));
  EXPECT_EQ(result->images[3].exclusion, "");
}

TEST(Incremental, IgnoresWrongGnssFixes) {
  const CaptureOptions options{
      .pixel_sigma_px = 0.5, .gnss_sigma_m = 0.3, .gnss_outlier_share = 0.25, .seed = 4};
  const Capture capture =
      CaptureWalk(MakeStreet({.points = 2000}), TestCamera(), LookAroundWalk(20), options);
  const auto result = Reconstruct(capture, MatchCapture(capture, 40, options));
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  const Errors errors = Compare(*result, capture);
  EXPECT_EQ(errors.registered, 20U);
  EXPECT_LT(errors.mean_position_m, 0.05);
  EXPECT_LT(errors.mean_absolute_m, 0.4);
}

// On a straight street positions leave the roll about it open; gravity, or else level cameras, must
// settle it.
TEST(Incremental, IsUprightOnAStraightStreet) {
  for (const auto& [gravity_sigma_rad, max_tilt_rad] :
       {std::pair{std::optional<double>(0.01), 0.01}, {std::nullopt, 0.06}}) {
    const CaptureOptions options{
        .pixel_sigma_px = 0.5, .gnss_sigma_m = 0.5, .gravity_sigma_rad = gravity_sigma_rad};
    const Capture capture = CaptureWalk(MakeStreet({.points = 2000}), TestCamera(),
                                        WalkStraight({0, 2, 1.7}, 1, 20), options);
    const auto result = Reconstruct(capture, MatchCapture(capture, 40, options));
    ASSERT_TRUE(result.ok()) << ToString(result.error());
    EXPECT_EQ(Compare(*result, capture).registered, 20U);
    for (std::size_t i = 0; i < 20; ++i) {
      const Eigen::Quaterniond truth_from_ours =
          capture.world_from_camera[i].rotation() *
          result->images[i].submap_from_camera->rotation().conjugate();
      const double tilt =
          std::acos(std::min(1.0, (truth_from_ours * Eigen::Vector3d::UnitZ()).z()));
      EXPECT_LT(tilt, max_tilt_rad);
    }
  }
}

TEST(Incremental, HasAConventionalGaugeWithoutGnss) {
  const CaptureOptions options{.gravity_sigma_rad = 0.005};
  const Capture capture =
      CaptureWalk(MakeStreet({.points = 1500}), TestCamera(), LookAroundWalk(9), options);
  const auto result = Reconstruct(capture, MatchCapture(capture, 40, options));
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  EXPECT_FALSE(result->is_geo_aligned);
  std::vector<double> baselines;
  for (std::size_t i = 1; i < 9; ++i) {
    baselines.push_back((result->images[i].submap_from_camera->translation() -
                         result->images[i - 1].submap_from_camera->translation())
                            .norm());
    const Eigen::Vector3d up =
        result->images[i].submap_from_camera->rotation() *
        (capture.world_from_camera[i].rotation().conjugate() * Eigen::Vector3d::UnitZ());
    EXPECT_GT(up.z(), std::cos(0.01));
  }
  std::sort(baselines.begin(), baselines.end());
  EXPECT_NEAR(baselines[4], 1, 1e-9);
}

TEST(Incremental, IsTheSameForTheSameInput) {
  const CaptureOptions options{.pixel_sigma_px = 0.5, .outlier_share = 0.2, .gnss_sigma_m = 1};
  const Capture capture =
      CaptureWalk(MakeStreet({.points = 1000}), TestCamera(), LookAroundWalk(8), options);
  const auto matches = MatchCapture(capture, 40, options);
  const auto a = Reconstruct(capture, matches);
  const auto b = Reconstruct(capture, matches);
  const auto threaded = Reconstruct(capture, matches, {.parallelism = {3}});
  ASSERT_TRUE(a.ok() && b.ok() && threaded.ok());
  EXPECT_EQ(a->points.size(), b->points.size());
  for (std::size_t i = 0; i < 8; ++i) {
    const Rigid3& pose = a->images[i].submap_from_camera->rigid();
    EXPECT_EQ(Difference(pose, b->images[i].submap_from_camera->rigid()).norm(), 0);
    EXPECT_EQ(Difference(pose, threaded->images[i].submap_from_camera->rigid()).norm(), 0);
  }
}

TEST(Incremental, RejectsIndicesOutOfRange) {
  const Capture capture =
      CaptureWalk(MakeStreet({.points = 300}), TestCamera(), LookAroundWalk(2), {});
  std::vector<PairMatches> matches = MatchCapture(capture, 1, {});
  matches[0].matches[0].second = 1000000;
  const auto result = Reconstruct(capture, matches);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
  matches[0].pair.second = 7;
  EXPECT_FALSE(Reconstruct(capture, matches).ok());
}

}  // namespace
}  // namespace waymark::mapping

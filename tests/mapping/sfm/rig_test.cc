// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <optional>

#include "mapping/sfm/incremental.h"
#include "mapping/synthetic/capture.h"
#include "mapping/synthetic/walk.h"

namespace waymark::mapping {
namespace {

constexpr double kBaselineM = 0.8;
constexpr double kStepM = 0.7;

CameraModel TestCamera() {
  const std::array parameters{500.0, 320.0, 240.0};
  return *CameraModel::Create(CameraKind::kSimplePinhole, 640, 480, parameters);
}

/// A vehicle going straight on; its left and right camera take turns.
std::vector<Rigid3> DriveWithTwoCameras(int count) {
  std::vector<Rigid3> walk;
  for (int i = 0; i < count; ++i) {
    const double side_m = (i % 2 == 0 ? -0.5 : 0.5) * kBaselineM;
    walk.push_back(PlaceCamera({side_m, 2 + kStepM * i, 1.7}, i % 2 == 0 ? 0.2 : -0.2));
  }
  return walk;
}

/// Each image against the other camera's before and after it, `baseline_m` aside.
std::vector<RigLink> LinkNeighbours(const std::vector<Rigid3>& walk, double baseline_m) {
  std::vector<RigLink> links;
  for (std::uint32_t i = 1; i + 1 < walk.size(); ++i) {
    const double side_m = i % 2 == 0 ? baseline_m : -baseline_m;
    links.push_back(
        {.image = i,
         .before = i - 1,
         .after = i + 1,
         .share = 0.5,
         .offset_in_camera = walk[i].rotation().conjugate() * Eigen::Vector3d(side_m, 0, 0)});
  }
  return links;
}

/// A drive whose GNSS is `gnss_stretch` times too long; absent: it has none.
struct Drive {
  explicit Drive(std::optional<double> gnss_stretch) {
    const CaptureOptions options{.pixel_sigma_px = 0.4,
                                 .gnss_sigma_m = gnss_stretch ? std::optional(0.3) : std::nullopt,
                                 .gravity_sigma_rad = 0.01};
    capture = CaptureWalk(MakeStreet({.points = 1200}), TestCamera(), walk, options);
    for (auto& fix : capture.gnss_in_world) {
      if (fix) *fix *= *gnss_stretch;
    }
    matches = MatchCapture(capture, 30, options);
  }

  Result<Reconstruction> Reconstruct(std::span<const RigLink> links) const {
    const std::array cameras{SfmCamera{capture.camera}};
    return ReconstructIncrementally(cameras, capture.Images(), matches, {.parallelism = {1}}, {},
                                    links);
  }

  /// Reconstructed over true metres.
  double Scale(const Reconstruction& result) const {
    std::vector<Eigen::Vector3d> from, to;
    for (std::size_t i = 0; i < walk.size(); ++i) {
      from.push_back(walk[i].translation());
      to.push_back(result.images[i].submap_from_camera->translation());
    }
    return EstimateSimilarity(from, to)->scale();
  }

  std::vector<Rigid3> walk = DriveWithTwoCameras(16);
  Capture capture{.camera = TestCamera(), .world_from_camera = {}};
  std::vector<PairMatches> matches;
};

TEST(Rig, TellsTheScaleBetterThanGnss) {
  const Drive drive(1.04);
  const auto without = drive.Reconstruct({});
  const auto with = drive.Reconstruct(LinkNeighbours(drive.walk, kBaselineM));
  ASSERT_TRUE(without.ok() && with.ok());
  EXPECT_GT(drive.Scale(*without), 1.02);
  EXPECT_FALSE(without->scale_sigma.has_value());
  EXPECT_TRUE(with->is_geo_aligned);
  EXPECT_NEAR(drive.Scale(*with), 1, 0.008);
  ASSERT_TRUE(with->scale_sigma.has_value());
  EXPECT_LT(*with->scale_sigma, 0.02);
}

TEST(Rig, MakesALocalMapMetric) {
  const Drive drive(std::nullopt);
  const auto result = drive.Reconstruct(LinkNeighbours(drive.walk, kBaselineM));
  ASSERT_TRUE(result.ok());
  EXPECT_FALSE(result->is_geo_aligned);
  EXPECT_NEAR(drive.Scale(*result), 1, 0.01);
}

TEST(Rig, IsNotBelievedWhenItContradictsGnssGrossly) {
  const Drive drive(1);
  const auto result = drive.Reconstruct(LinkNeighbours(drive.walk, 2 * kBaselineM));
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(drive.Scale(*result), 1, 0.03);
  EXPECT_FALSE(result->scale_sigma.has_value());
}

TEST(Rig, RefusesLinksOfImagesThatAreNotThere) {
  const Drive drive(1);
  std::vector<RigLink> links = LinkNeighbours(drive.walk, kBaselineM);
  links[3].after = 16;
  EXPECT_EQ(drive.Reconstruct(links).error().code, ErrorCode::kInvalidArgument);
  links[3].after = links[3].before;
  EXPECT_EQ(drive.Reconstruct(links).error().code, ErrorCode::kInvalidArgument);
}

/// Eight cameras across a vehicle, turned against each other by 0.1 rad, that fire in turn.
class EightCameras {
 public:
  static constexpr std::uint32_t kCount = 8;

  std::vector<Rigid3> Drive(std::uint32_t images) const {
    std::vector<Rigid3> walk;
    for (std::uint32_t i = 0; i < images; ++i) {
      walk.push_back(PlaceCamera({SideM(i), 2 + 0.15 * i, 1.7}, 0.1 * (i % kCount) - 0.35));
    }
    return walk;
  }

  /// Each image against the camera that fires half a turn before and after it.
  std::vector<RigLink> Link(const std::vector<Rigid3>& walk) const {
    constexpr std::uint32_t kHalf = kCount / 2;
    std::vector<RigLink> links;
    for (std::uint32_t i = kHalf; i + kHalf < walk.size(); ++i) {
      const Eigen::Vector3d aside(SideM(i + kHalf) - SideM(i), 0, 0);
      links.push_back({.image = i,
                       .before = i - kHalf,
                       .after = i + kHalf,
                       .share = 0.5,
                       .offset_in_camera = walk[i].rotation().conjugate() * aside});
    }
    return links;
  }

 private:
  static double SideM(std::uint32_t image) { return 0.2 * (image % kCount) - 0.7; }
};

TEST(Rig, EightCamerasThatFireInTurnAreOneMetricModel) {
  const EightCameras rig;
  const std::vector<Rigid3> walk = rig.Drive(32);
  const CaptureOptions options{.pixel_sigma_px = 0.4, .gravity_sigma_rad = 0.01};
  const Capture capture = CaptureWalk(MakeStreet({.points = 500}), TestCamera(), walk, options);
  const std::vector<SfmCamera> cameras(EightCameras::kCount, SfmCamera{capture.camera});
  std::vector<SfmImage> images = capture.Images();
  for (std::uint32_t i = 0; i < images.size(); ++i) images[i].camera = i % EightCameras::kCount;
  const auto result = ReconstructIncrementally(cameras, images, MatchCapture(capture, 30, options),
                                               {.parallelism = {1}}, {}, rig.Link(walk));
  ASSERT_TRUE(result.ok());
  std::vector<Eigen::Vector3d> from, to;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    ASSERT_TRUE(result->images[i].submap_from_camera.has_value()) << i;
    from.push_back(walk[i].translation());
    to.push_back(result->images[i].submap_from_camera->translation());
  }
  const auto submap_from_world = EstimateSimilarity(from, to);
  ASSERT_TRUE(submap_from_world.ok());
  EXPECT_NEAR(submap_from_world->scale(), 1, 0.01);
  for (std::size_t i = 0; i < walk.size(); ++i) {
    EXPECT_LT((*submap_from_world * from[i] - to[i]).norm(), 0.03) << i;
    EXPECT_LT(AngleBetween(submap_from_world->rotation() * walk[i].rotation(),
                           result->images[i].submap_from_camera->rotation())
                  .radians(),
              0.004)
        << i;
  }
}

}  // namespace
}  // namespace waymark::mapping

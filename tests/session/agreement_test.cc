// SPDX-License-Identifier: Apache-2.0
#include "session/device/agreement.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <random>

#include "mapping/base/quantile.h"

namespace waymark::session {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

Transform<Map, Device> At(double x) { return {Eigen::Quaterniond::Identity(), {x, 0, 0}}; }

DevicePose Self() {
  return {.state = localiser::AlignmentState::kFixed,
          .map_from_device = At(0),
          .covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4,
          .epoch = 3,
          .time = {}};
}
OtherDevice Ben(double x) {
  return {.id = DeviceId("ben"),
          .name = "Ben",
          .map_from_device = At(x),
          .certainty = {.sigma_m = 0.02, .rotation_sigma_rad = 0.005},
          .epoch = 3};
}
SharedAnchor Anchor(double x) {
  return {.id = AnchorId("a"),
          .owner = DeviceId("ben"),
          .map_from_anchor = {Eigen::Quaterniond::Identity(), {x, 0, 0}},
          .epoch = 3,
          .kind = "",
          .payload = ""};
}

// Both draw the same content with errors as they say, in a map that is off by as much for both: the
// distances are as expected.
TEST(Agreement, IsTheDistanceThatErrorsOfSuchSizeBringAbout) {
  std::mt19937_64 bits(4);
  std::normal_distribution<double> normal;
  const double map_sigma_m = localiser::AlignmentOptions{}.sigma_floor_m;
  const PoseCertainty anna_in_map{0.03, 0.01}, ben_in_map{0.05, 0.002};
  const PoseCertainty anna{std::hypot(0.03, map_sigma_m), 0.01};
  const PoseCertainty ben{std::hypot(0.05, map_sigma_m), 0.002};
  const auto shown_by = [&](const PoseCertainty& certainty, double distance_m) {
    const Eigen::Vector3d ahead(distance_m, 0, 0);
    const auto three = [&](double sigma) {
      return Eigen::Vector3d(sigma * normal(bits), sigma * normal(bits), sigma * normal(bits));
    };
    const Rigid3 error(RotationFromVector(three(certainty.rotation_sigma_rad)),
                       three(certainty.sigma_m));
    return Eigen::Vector3d(error * ahead - ahead);
  };
  std::vector<double> apart_m;
  for (int i = 0; i < 20'000; ++i)
    apart_m.push_back((shown_by(anna_in_map, 6) - shown_by(ben_in_map, 15)).norm());
  const ExpectedDistance expected = ExpectDistance(anna, 6, ben, 15);
  EXPECT_NEAR(Quantile(apart_m, 0.5) / expected.p50_m, 1, 0.05);
  EXPECT_NEAR(Quantile(apart_m, 0.95) / expected.p95_m, 1, 0.05);
}

TEST(Agreement, IsOfThoseWhoAreThereInTheSameMapAndNearTheAnchor) {
  const std::vector<SharedAnchor> anchors{Anchor(5)};
  const auto with = [&](const OtherDevice& other) {
    return ExpectAgreements(Self(), std::array{other}, anchors);
  };
  ASSERT_THAT(with(Ben(10)), SizeIs(1));
  EXPECT_EQ(with(Ben(10))[0].other, DeviceId("ben"));
  EXPECT_LT(with(Ben(10))[0].apart.p50_m, with(Ben(20))[0].apart.p50_m);
  EXPECT_THAT(with(Ben(26)), IsEmpty()) << "too far away";
  OtherDevice other = Ben(10);
  other.is_present = false;
  EXPECT_THAT(with(other), IsEmpty());
  other = Ben(10);
  other.epoch = 2;
  EXPECT_THAT(with(other), IsEmpty());
  other = Ben(10);
  other.map_from_device.reset();
  EXPECT_THAT(with(other), IsEmpty());
  EXPECT_THAT(ExpectAgreements({}, std::array{Ben(10)}, anchors), IsEmpty());
  EXPECT_THAT(ExpectAgreements(Self(), std::array{Ben(10)}, std::array{Anchor(21)}), IsEmpty());
}

}  // namespace
}  // namespace waymark::session

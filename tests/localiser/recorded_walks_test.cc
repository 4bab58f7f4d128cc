// SPDX-License-Identifier: Apache-2.0
// Two real ARKit walks past the same AprilTags: one serves as the map, the other as the phone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <vector>

#include <nlohmann/json.hpp>

#include "localiser/odometry_alignment.h"
#include "mapping/base/file.h"
#include "mapping/base/median.h"

namespace waymark::localiser {
namespace {

struct Sighting {
  int tag;
  double time_s;
  Rigid3 vo_from_device;  // z up, camera axes as ours
  Rigid3 device_from_tag;
};

Rigid3 RigidFromNumbers(const nlohmann::json& numbers, bool is_column_major) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = numbers[i].get<double>();
  if (is_column_major) matrix.transposeInPlace();
  return {Eigen::Quaterniond(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>())),
          matrix.topRightCorner<3, 1>()};
}

std::vector<Sighting> LoadSightings(const std::filesystem::path& path) {
  const auto text = LoadTextFile(path);
  CHECK(text.ok(), "{}", ToString(text.error()));
  const nlohmann::json walk = nlohmann::json::parse(*text);
  // ARKit's world is y up and its camera looks along -z; ours are z up and +z.
  const Rigid3 z_up_from_y_up(RotationFromVector({M_PI / 2, 0, 0}), Eigen::Vector3d::Zero());
  const Rigid3 turned(RotationFromVector({M_PI, 0, 0}), Eigen::Vector3d::Zero());
  std::map<int, Rigid3> poses;
  for (const auto& pose : walk["pose_data"]) {
    poses[pose["id"]] = z_up_from_y_up * RigidFromNumbers(pose["pose"], true) * turned;
  }
  std::vector<Sighting> sightings;
  for (const auto& group : walk["tag_data"]) {
    for (const auto& tag : group) {
      sightings.push_back({tag["tag_id"], tag["timestamp"], poses.at(tag["pose_id"]),
                           RigidFromNumbers(tag["tag_pose"], false)});
    }
  }
  std::sort(sightings.begin(), sightings.end(),
            [](const Sighting& a, const Sighting& b) { return a.time_s < b.time_s; });
  return sightings;
}

MapFix FixFrom(const Sighting& sighting, const Rigid3& map_from_tag) {
  const Rigid3 map_from_device = map_from_tag * sighting.device_from_tag.Inverse();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance.diagonal() << 0.04, 0.04, 0.04, 0.01, 0.01, 0.01;  // a small tag turns easily
  return {.time = FromNanoseconds<DeviceTime>(static_cast<std::int64_t>(sighting.time_s * 1e9)),
          .vo_from_device = Transform<Vo, Device>(sighting.vo_from_device),
          .map_from_device = Transform<Map, Device>(map_from_device),
          .covariance = covariance,
          .submap = SubmapId("tags"),
          .submap_from_camera = Transform<Submap, Camera>(map_from_device),
          .camera_from_device = {}};
}

TEST(RecordedWalks, SlidingAlignmentBeatsTheBestSingleOneDespiteGrossErrors) {
  const char* data = std::getenv("WAYMARK_DATA");
  if (data == nullptr) GTEST_SKIP() << "WAYMARK_DATA names no folder with arkit_walks";
  const auto folder = std::filesystem::path(data) / "arkit_walks";
  std::map<int, Rigid3> map_from_tag;  // as first seen by the walk that makes the map
  for (const Sighting& s : LoadSightings(folder / "straight_209_occam.json")) {
    map_from_tag.emplace(s.tag, s.vo_from_device * s.device_from_tag);
  }
  const std::vector<Sighting> phone = LoadSightings(folder / "oblique_209_occam.json");
  ASSERT_GT(phone.size(), 100u);

  OdometryAlignment sliding({});
  OdometryAlignment single(
      {.half_life = std::chrono::hours(100), .drift_share = 0, .max_fixes = 1000});
  for (const Sighting& s : phone) single.AddFix(FixFrom(s, map_from_tag.at(s.tag)));  // no errors
  const Alignment best_single = single.Estimate(single.fixes().back().time);

  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> sliding_errors_m;
  std::vector<double> single_errors_m;
  for (const Sighting& sighting : phone) {
    MapFix fix = FixFrom(sighting, map_from_tag.at(sighting.tag));
    const Eigen::Vector3d truth = fix.map_from_device.translation();
    const Alignment now = sliding.Estimate(fix.time);
    if (now.state == AlignmentState::kFixed) {  // judged before it hears of this sighting
      const auto error = [&](const Alignment& alignment) {
        return ((*alignment.map_from_vo * fix.vo_from_device).translation() - truth).norm();
      };
      sliding_errors_m.push_back(error(now));
      single_errors_m.push_back(error(best_single));
    }
    if (uniform(engine) < -0.6) {  // one in five
      fix.map_from_device = Transform<Map, Device>(
          fix.map_from_device.rotation(),
          truth + 30 * Eigen::Vector3d(uniform(engine), uniform(engine), 0.1 * uniform(engine)));
    }
    sliding.AddFix(fix);
  }
  RecordProperty("judged", static_cast<int>(sliding_errors_m.size()));
  const double sliding_m = Median(sliding_errors_m);
  const double single_m = Median(single_errors_m);
  std::printf("%zu of %zu sightings judged: median error %.2f m sliding, %.2f m single\n",
              sliding_errors_m.size(), phone.size(), sliding_m, single_m);
  EXPECT_GT(sliding_errors_m.size(), phone.size() / 2);
  EXPECT_LT(sliding_m, single_m);
}

}  // namespace
}  // namespace waymark::localiser

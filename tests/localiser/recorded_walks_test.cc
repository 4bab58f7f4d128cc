// SPDX-License-Identifier: Apache-2.0
// Two real ARKit walks past the same AprilTags: one serves as the map, the other as the phone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <random>
#include <span>
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

/// One walk's sightings as fixes of a phone, the other walk's tags as the map.
struct Walks {
  std::map<int, Rigid3> map_from_tag;  // as first seen by the walk that makes the map
  std::vector<Sighting> phone;
};

std::optional<Walks> LoadWalks() {
  const char* data = std::getenv("WAYMARK_DATA");
  if (data == nullptr) return std::nullopt;
  const auto folder = std::filesystem::path(data) / "arkit_walks";
  Walks walks{.map_from_tag = {}, .phone = LoadSightings(folder / "oblique_209_occam.json")};
  for (const Sighting& s : LoadSightings(folder / "straight_209_occam.json")) {
    walks.map_from_tag.emplace(s.tag, s.vo_from_device * s.device_from_tag);
  }
  return walks;
}

/// How far two ways of joining odometry to the map are off at one sighting, before they hear of it.
struct Agreement {
  double time_s = 0;  // since the first sighting
  double sliding_m = 0;
  double single_m = 0;  // the best rigid alignment of the whole walk, which saw no gross errors
};

double ErrorOf(const Alignment& alignment, const MapFix& fix) {
  return ((*alignment.map_from_vo * fix.vo_from_device).translation() -
          fix.map_from_device.translation())
      .norm();
}

/// Every fifth fix is off by up to 30 m, after it was judged.
std::vector<Agreement> Follow(const Walks& walks, const AlignmentOptions& options) {
  OdometryAlignment sliding(options);
  OdometryAlignment single({.half_life = std::chrono::hours(100),
                            .drift_share = 0,
                            .max_fixes = 1000,
                            .freedom = options.freedom});
  for (const Sighting& s : walks.phone) {
    single.AddFix(FixFrom(s, walks.map_from_tag.at(s.tag)));  // no errors
  }
  const Alignment best_single = single.Estimate(single.fixes().back().time);
  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Agreement> agreements;
  for (const Sighting& sighting : walks.phone) {
    MapFix fix = FixFrom(sighting, walks.map_from_tag.at(sighting.tag));
    const Alignment now = sliding.Estimate(fix.time);
    if (now.state == AlignmentState::kFixed) {
      agreements.push_back({sighting.time_s - walks.phone.front().time_s, ErrorOf(now, fix),
                            ErrorOf(best_single, fix)});
    }
    if (uniform(engine) < -0.6) {
      fix.map_from_device = Transform<Map, Device>(
          fix.map_from_device.rotation(),
          fix.map_from_device.translation() +
              30 * Eigen::Vector3d(uniform(engine), uniform(engine), 0.1 * uniform(engine)));
    }
    sliding.AddFix(fix);
  }
  return agreements;
}

double MedianOf(std::span<const Agreement> agreements, double Agreement::*error_m) {
  std::vector<double> errors_m;
  for (const Agreement& agreement : agreements) errors_m.push_back(agreement.*error_m);
  return Median(std::move(errors_m));
}

/// Medians of each stretch of time.
void Print(std::span<const Agreement> agreements, double stretch_s) {
  std::printf("%9s %10s %11s %10s\n", "seconds", "sightings", "sliding, m", "single, m");
  for (auto begin = agreements.begin(); begin != agreements.end();) {
    const double until_s = stretch_s * (1 + std::floor(begin->time_s / stretch_s));
    const auto end = std::find_if(begin, agreements.end(),
                                  [&](const Agreement& a) { return a.time_s >= until_s; });
    const std::span<const Agreement> stretch(begin, end);
    std::printf("%4.0f-%4.0f %10zu %11.2f %10.2f\n", until_s - stretch_s, until_s, stretch.size(),
                MedianOf(stretch, &Agreement::sliding_m), MedianOf(stretch, &Agreement::single_m));
    begin = end;
  }
}

class RecordedWalks : public testing::TestWithParam<AlignmentFreedom> {};

TEST_P(RecordedWalks, SlidingAlignmentBeatsTheBestSingleOneDespiteGrossErrors) {
  const std::optional<Walks> walks = LoadWalks();
  if (!walks) GTEST_SKIP() << "WAYMARK_DATA names no folder with arkit_walks";
  ASSERT_GT(walks->phone.size(), 100u);
  const auto agreements = Follow(*walks, {.freedom = GetParam()});
  ASSERT_GT(agreements.size(), walks->phone.size() / 2);
  Print(agreements, 30);
  const double sliding_m = MedianOf(agreements, &Agreement::sliding_m);
  const double single_m = MedianOf(agreements, &Agreement::single_m);
  std::printf("%zu of %zu sightings judged: median error %.2f m sliding, %.2f m single\n",
              agreements.size(), walks->phone.size(), sliding_m, single_m);
  EXPECT_LT(sliding_m, single_m / 2);
}

INSTANTIATE_TEST_SUITE_P(Freedoms, RecordedWalks,
                         testing::Values(AlignmentFreedom::kYawAndTranslation,
                                         AlignmentFreedom::kFull),
                         [](const auto& freedom) {
                           return freedom.param == AlignmentFreedom::kFull ? "Six" : "Four";
                         });

}  // namespace
}  // namespace waymark::localiser

// SPDX-License-Identifier: Apache-2.0
#include "tests/mapping/pipeline/facade.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "mapping/base/check.h"
#include "mapping/experience/kapture.h"

namespace waymark::mapping {
namespace {

constexpr int kWidthPx = 320;
constexpr int kHeightPx = 240;
constexpr double kWallX = 6;

CameraModel FacadeCamera() {
  return *CameraModel::Create(CameraKind::kPinhole, kWidthPx, kHeightPx,
                              std::array<double, 4>{260, 260, 160, 120});
}

double Hash(std::uint64_t world, std::int64_t a, std::int64_t b) {
  std::uint64_t h = world * 0x9E3779B97F4A7C15u +
                    static_cast<std::uint64_t>(a) * 0xC2B2AE3D27D4EB4Fu +
                    static_cast<std::uint64_t>(b) * 0x165667B19E3779F9u;
  h ^= h >> 31;
  h *= 0xD6E8FEB86659FD93u;
  h ^= h >> 32;
  h *= 0xD6E8FEB86659FD93u;
  return static_cast<double>(h >> 40) / static_cast<double>(1 << 24);
}

/// Smooth noise between 0 and 1 with features of the given size.
double Noise(std::uint64_t world, double u, double v, double size_m) {
  const double x = u / size_m;
  const double y = v / size_m;
  const auto i = static_cast<std::int64_t>(std::floor(x));
  const auto j = static_cast<std::int64_t>(std::floor(y));
  const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
  const double s = smooth(x - static_cast<double>(i));
  const double t = smooth(y - static_cast<double>(j));
  return (1 - t) * ((1 - s) * Hash(world, i, j) + s * Hash(world, i + 1, j)) +
         t * ((1 - s) * Hash(world, i, j + 1) + s * Hash(world, i + 1, j + 1));
}

/// The distance in x at which a ray meets the front: bays of 2.5 m stand out by up to 1.5 m.
double FrontX(std::uint64_t world, double along_m) {
  return kWallX - 1.5 * Hash(world, static_cast<std::int64_t>(std::floor(along_m / 2.5)), 77);
}

double Shade(std::uint64_t world, const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  // March to the front; the faces of the bays' sides are met where the step jumps over them.
  double t = 0;
  for (int i = 0; i < 400; ++i, t += 0.03) {
    const Eigen::Vector3d p = from + t * direction;
    if (p.x() >= FrontX(world, p.y())) break;
  }
  const Eigen::Vector3d near = from + std::max(0.0, t - 0.03) * direction;
  const double front_x = FrontX(world, (from + t * direction).y());
  Eigen::Vector3d hit = from + t * direction;
  if (near.x() < front_x && direction.x() > 1e-6) {
    hit = from + (front_x - from.x()) / direction.x() * direction;
  }
  const double u = hit.y() + 0.7 * hit.x();
  return 0.45 * Noise(world, u, hit.z(), 0.35) + 0.35 * Noise(world + 1, u, hit.z(), 0.15) +
         0.2 * Noise(world + 2, u, hit.z(), 1.1);
}

void RenderImage(const std::filesystem::path& path, const Rigid3& map_from_camera,
                 std::uint64_t world) {
  const CameraModel camera = FacadeCamera();
  cv::Mat image(kHeightPx, kWidthPx, CV_8U);
  for (int y = 0; y < kHeightPx; ++y) {
    for (int x = 0; x < kWidthPx; ++x) {
      const Eigen::Vector3d direction =
          map_from_camera.rotation() * camera.Unproject({x + 0.5, y + 0.5});
      image.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(255 * Shade(world, map_from_camera.translation(), direction));
    }
  }
  CHECK(cv::imwrite(path.string(), image), "cannot write {}", path.string());
}

/// Looks at the house (east), a little forward, level.
Rigid3 PoseAt(const FacadeDriveOptions& options, int i) {
  Eigen::Matrix3d axes;  // camera x, y, z in map: north-south along the street, down, east
  axes.col(0) = -Eigen::Vector3d::UnitY();
  axes.col(1) = -Eigen::Vector3d::UnitZ();
  axes.col(2) = Eigen::Vector3d::UnitX();
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.02 * std::sin(i), Eigen::Vector3d::UnitZ()));
  return {turn * Eigen::Quaterniond(axes),
          {options.aside_m + 0.2 * std::sin(0.7 * i), options.first_m + i * options.step_m,
           1.5 + 0.1 * std::cos(0.9 * i)}};
}

SensorTime TimeOf(int i) { return FromNanoseconds<SensorTime>(std::int64_t{i} * 500'000'000); }

void AddImu(const FacadeDriveOptions& options, Experience& drive) {
  for (const char* sensor : {"acc0", "gyro0"}) {
    drive.rigs.push_back({"rig0", sensor, Rigid3()});
  }
  const SensorTime end = TimeOf(options.images - 1);
  for (SensorTime t = TimeOf(0); t <= end; t += std::chrono::milliseconds(10)) {
    const double i = Seconds(t.time_since_epoch()) / 0.5;
    drive.accelerometer.push_back({t, "acc0", {0, -9.80665, 0}});
    // Of the turn in PoseAt, about the vertical, which is -y of the camera.
    drive.gyroscope.push_back({t, "gyro0", {0, -0.02 * std::cos(i) / 0.5, 0}});
  }
}

}  // namespace

GeoPoint StreetOrigin() { return {Angle::Degrees(37.77), Angle::Degrees(-122.42), 12}; }

FacadeTruth MakeFacadeDrive(const std::filesystem::path& folder,
                            const FacadeDriveOptions& options) {
  Experience drive{ExperienceId(folder.filename().string()), folder, {}, {}, {}, {}, {}, {}, {}};
  drive.cameras.emplace("cam0", CameraSensor{"cam0", FacadeCamera(), true});
  drive.rigs.push_back({"rig0", "cam0", Rigid3()});
  if (options.has_gnss) drive.rigs.push_back({"rig0", "gps0", Rigid3()});
  std::filesystem::create_directories(folder / "sensors" / "records_data");
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> noise(0, options.gnss_noise_m);
  const TangentPlane plane(StreetOrigin());
  FacadeTruth truth;
  for (int i = 0; i < options.images; ++i) {
    const std::string name = fmt::format("{:04}.png", i);
    const Rigid3 pose = PoseAt(options, i);
    RenderImage(folder / "sensors" / "records_data" / name, pose, options.world);
    truth[name] = pose;
    drive.images.push_back({TimeOf(i), "cam0", name});
    if (!options.has_gnss) continue;
    const Eigen::Vector3d fix =
        pose.translation() + Eigen::Vector3d(noise(random), noise(random), noise(random));
    drive.gnss.push_back({TimeOf(i), "gps0", plane.ToGeo(Point<Map>(fix)), 0.05});
  }
  if (options.has_imu) AddImu(options, drive);
  const auto stored = StoreKapture(drive, folder);
  CHECK(stored.ok(), "{}", stored.error().message);
  return truth;
}

}  // namespace waymark::mapping

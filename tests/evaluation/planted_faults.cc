// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/planted_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "examples/simulator/random.h"
#include "mapping/synthetic/fault.h"

namespace waymark::evaluation {
namespace {

double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Bends are made as turns per second, which is what a gyroscope can tell from its bias.
void AddBends(std::vector<PlantedFault>& faults) {
  const auto add = [&](const char* kind, double degrees_per_s, mapping::BendFault per_rad_per_s) {
    faults.push_back(
        {kind, fmt::format("{:.1f} deg/s", degrees_per_s), {}, [=](BuiltSubmap& submap) {
           mapping::BendFault fault = per_rad_per_s;
           const double whole_rad =
               Radians(degrees_per_s) *
               Seconds(submap.images.back().time - submap.images.front().time) /
               (fault.back ? 2 : 1);
           fault.yaw_rad *= whole_rad;
           fault.pitch_rad *= whole_rad;
           fault.roll_rad *= whole_rad;
           mapping::Bend(fault, submap.reconstruction);
         }});
  };
  for (const double rate : {0.8, 1.5, 3.0}) {
    add("warped: yaw", rate, {.yaw_rad = 1});
    add("warped: yaw and back", rate, {.yaw_rad = 1, .back = true});
    add("warped: pitch", rate, {.pitch_rad = 1});
    add("warped: roll", rate, {.roll_rad = 1});
  }
}

void AddOtherOutcomes(std::vector<PlantedFault>& faults) {
  const auto add = [&](const char* kind, std::string strength, auto spoil) {
    faults.push_back({kind, std::move(strength), {}, [spoil](BuiltSubmap& submap) {
                        spoil(submap.reconstruction);
                      }});
  };
  using mapping::Reconstruction;
  for (const double degrees : {4.0, 10.0, 45.0}) {
    add("hinged", fmt::format("{:.0f} deg", degrees),
        [degrees](Reconstruction& r) { mapping::Hinge(r.images.size() / 2, Radians(degrees), r); });
  }
  for (const double ratio : {1.4, 1.8, 0.5, 2.5}) {
    add("scale drift", fmt::format("x {:.2f}", ratio),
        [ratio](Reconstruction& r) { mapping::DriftScale(ratio, r); });
  }
  for (const double metres : {4.0, 12.0, 30.0}) {
    add("wrong loop: folded", fmt::format("{:.0f} m", metres),
        [metres](Reconstruction& r) { mapping::Fold(2 * r.images.size() / 3, metres, r); });
  }
  add("mirrored", "whole", [](Reconstruction& r) { mapping::Mirror(r); });
}

/// Index of the image whose stamp is nearest to a time.
std::size_t ImageAt(const SimulatedDrive& drive, double seconds) {
  const auto found = std::ranges::lower_bound(drive.seconds, seconds);
  return std::min(drive.seconds.size() - 1,
                  static_cast<std::size_t>(found - drive.seconds.begin()));
}

void SeeFrom(SimulatedDrive& drive, std::size_t image, double seconds) {
  drive.seen_from[image] =
      drive.motion.WorldFromBody(seconds) * drive.body_from_camera[drive.camera_of_image[image]];
}

// As if the street looked there as it did a while ago.
void LoopWrongly(SimulatedDrive& drive, double share, double back_s) {
  const double begin_s = (1 - share) * drive.duration_s();
  for (std::size_t i = ImageAt(drive, begin_s); i < drive.seconds.size(); ++i) {
    SeeFrom(drive, i, drive.seconds[i] - back_s);
  }
}

void SwapImages(SimulatedDrive& drive, double share, std::uint64_t seed) {
  simulator::Random random(seed);
  const std::size_t begin = drive.seconds.size() / 3;
  const auto count = static_cast<std::size_t>(share * static_cast<double>(drive.seconds.size()));
  for (std::size_t k = count - 1; k > 0; --k) {
    const auto other = static_cast<std::size_t>(random.Integer(0, static_cast<int>(k) - 1));
    const std::size_t i = begin + k;
    const std::size_t j = begin + other;
    if (drive.camera_of_image[i] == drive.camera_of_image[j]) {
      std::swap(drive.seen_from[i], drive.seen_from[j]);
    }
  }
}

void Freeze(SimulatedDrive& drive, double begin_s, double length_s) {
  for (std::size_t i = 0; i < drive.seconds.size(); ++i) {
    if (drive.seconds[i] >= begin_s && drive.seconds[i] < begin_s + length_s) {
      SeeFrom(drive, i, begin_s);
    }
  }
}

void DropImages(SimulatedDrive& drive, double begin_s, double length_s) {
  SimulatedDrive kept = drive;
  kept.camera_of_image.clear();
  kept.seconds.clear();
  kept.true_poses.clear();
  kept.seen_from.clear();
  for (std::size_t i = 0; i < drive.seconds.size(); ++i) {
    if (drive.seconds[i] >= begin_s && drive.seconds[i] < begin_s + length_s) continue;
    kept.camera_of_image.push_back(drive.camera_of_image[i]);
    kept.seconds.push_back(drive.seconds[i]);
    kept.true_poses.push_back(drive.true_poses[i]);
    kept.seen_from.push_back(drive.seen_from[i]);
  }
  drive = std::move(kept);
}

void ShiftClock(SimulatedDrive& drive, double from_s, double by_s) {
  const auto shift = [&](auto& records) {
    for (auto& record : records) {
      if (1e-9 * static_cast<double>(ToNanoseconds(record.time)) < from_s) continue;
      record.time += std::chrono::nanoseconds(std::llround(1e9 * by_s));
    }
  };
  shift(drive.experience.gnss);
  shift(drive.experience.accelerometer);
  shift(drive.experience.gyroscope);
}

// The offset grows for `ramp_s` (0: at once) and stays.
void LieAboutPlace(SimulatedDrive& drive, double metres, double ramp_s) {
  const TangentPlane plane(GeoPoint{Angle::Degrees(47.37), Angle::Degrees(8.54), 450});
  const double from_s = 0.45 * drive.duration_s();
  simulator::Random random(drive.seed + 77);
  const double yaw = random.Uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d offset = metres * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0);
  for (mapping::GnssRecord& record : drive.experience.gnss) {
    const double since_s = 1e-9 * static_cast<double>(ToNanoseconds(record.time)) - from_s;
    if (since_s < 0) continue;
    const double share = ramp_s > 0 ? std::min(1.0, since_s / ramp_s) : 1;
    record.place =
        plane.ToGeo(Point<Map>(plane.ToMap(record.place).coordinates() + share * offset));
  }
}

void AddRecordings(std::vector<PlantedFault>& faults) {
  const auto add = [&](const char* kind, std::string strength, auto spoil) {
    faults.push_back({kind, std::move(strength), spoil, {}});
  };
  for (const double share : {0.15, 0.3, 0.5}) {
    add("wrong loop: looks alike", fmt::format("{:.0f} % of images", 100 * share),
        [share](SimulatedDrive& drive) { LoopWrongly(drive, share, 3); });
  }
  for (const double share : {0.1, 0.2, 0.4}) {
    add("images swapped", fmt::format("{:.0f} % of images", 100 * share),
        [share](SimulatedDrive& drive) { SwapImages(drive, share, drive.seed); });
  }
  for (const double seconds : {1.0, 2.0, 4.0}) {
    add("camera dropped: hangs", fmt::format("{:.0f} s", seconds),
        [seconds](SimulatedDrive& drive) { Freeze(drive, 4, seconds); });
  }
  for (const double seconds : {2.0, 4.0}) {
    add("camera dropped: silent", fmt::format("{:.0f} s", seconds),
        [seconds](SimulatedDrive& drive) { DropImages(drive, 4, seconds); });
  }
  for (const double seconds : {0.2, 1.0, 3.0}) {
    add("clock jump", fmt::format("{:.1f} s", seconds),
        [seconds](SimulatedDrive& drive) { ShiftClock(drive, 0.5 * drive.duration_s(), seconds); });
  }
  for (const double metres : {8.0, 20.0, 60.0}) {
    add("lying GNSS: jump", fmt::format("{:.0f} m", metres),
        [metres](SimulatedDrive& drive) { LieAboutPlace(drive, metres, 0); });
  }
  for (const double metres : {5.0, 15.0}) {
    add("lying GNSS: ramp", fmt::format("{:.0f} m", metres),
        [metres](SimulatedDrive& drive) { LieAboutPlace(drive, metres, 6); });
  }
}

}  // namespace

std::vector<PlantedFault> PlantedFaults() {
  std::vector<PlantedFault> faults;
  AddBends(faults);
  AddOtherOutcomes(faults);
  AddRecordings(faults);
  return faults;
}

}  // namespace waymark::evaluation

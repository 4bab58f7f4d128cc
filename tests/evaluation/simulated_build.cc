// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "mapping/pipeline/internal/image_sensing.h"
#include "mapping/submap/prune.h"
#include "tests/evaluation/simulated_drive.h"
#include "tests/evaluation/trajectory.h"

namespace waymark::evaluation {
namespace {

using namespace mapping;

const GeoPoint kOrigin{Angle::Degrees(47.37), Angle::Degrees(8.54), 450};

CameraModel DriveCamera() {
  const std::array parameters{417.0, 320.0, 240.0, -0.03};
  return *CameraModel::Create(CameraKind::kSimpleRadial, 640, 480, parameters);
}

std::string CameraName(std::uint32_t camera) { return fmt::format("camera{}", camera); }

std::vector<IndexedImage> Sense(const SimulatedDrive& drive, const TangentPlane& plane) {
  Experience experience = drive.experience;
  for (std::uint32_t c = 0; c < drive.body_from_camera.size(); ++c) {
    experience.cameras.emplace(CameraName(c), CameraSensor{CameraName(c), DriveCamera()});
    experience.rigs.push_back({"rig", CameraName(c), drive.body_from_camera[c].Inverse()});
  }
  std::vector<IndexedImage> images;
  for (std::size_t i = 0; i < drive.seconds.size(); ++i) {
    IndexedImage image{.name = fmt::format("{:06}", i),
                       .time = FromNanoseconds<SensorTime>(std::llround(1e9 * drive.seconds[i])),
                       .camera = drive.camera_of_image[i]};
    images.push_back(std::move(image));
  }
  SenseImages(experience, plane, images);
  return images;
}

CameraModel GuessCamera() {  // a little wrong, as calibrations are
  const std::array parameters{421.0, 320.0, 240.0, 0.0};
  return *CameraModel::Create(CameraKind::kSimpleRadial, 640, 480, parameters);
}

}  // namespace

Result<BuiltSubmap> Build(const SimulatedDrive& drive, const Shutter& shutter) {
  const TangentPlane plane(kOrigin);
  const std::vector<IndexedImage> sensed = Sense(drive, plane);
  const CaptureOptions options{.pixel_sigma_px = 0.5,
                               .outlier_share = 0.15,
                               .max_range_m = 40,
                               .max_features = 550,
                               .readout_s = shutter.readout_s,
                               .pose_at =
                                   [&](std::size_t i, double seconds) {
                                     return drive.motion.WorldFromBody(drive.seconds[i] + seconds) *
                                            drive.body_from_camera[drive.camera_of_image[i]];
                                   },
                               .seed = drive.seed};
  const Capture capture = CaptureWalk(drive.world, DriveCamera(), drive.seen_from, options);
  std::vector<SfmImage> images = capture.Images();
  BuiltSubmap built;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (sensed[i].gnss) {
      images[i].gnss_in_submap = Point<Submap>(plane.ToMap(*sensed[i].gnss).coordinates());
    }
    images[i].gnss_sigma_m = sensed[i].gnss_sigma_m;
    images[i].up_in_camera = sensed[i].up_in_camera;
    images[i].time_s = drive.seconds[i];
    built.images.push_back({.sequence = CameraName(sensed[i].camera),
                            .time = sensed[i].time,
                            .up_in_camera = sensed[i].up_in_camera,
                            .gnss_in_submap = images[i].gnss_in_submap,
                            .gnss_sigma_m = sensed[i].gnss_sigma_m});
    built.next_from_this.push_back(sensed[i].next_from_this);
  }
  const std::array cameras{
      SfmCamera{.model = GuessCamera(), .readout_s = shutter.stated_readout_s}};
  WAYMARK_TRY_ASSIGN(built.reconstruction,
                     ReconstructIncrementally(cameras, images, MatchCapture(capture, 25, options),
                                              {.parallelism = {1}}));
  built.true_poses = drive.true_poses;
  return built;
}

std::vector<MeasuredRotation> BuiltSubmap::Rotations() const {
  struct Run {
    std::optional<std::uint32_t> from;
    Eigen::Quaterniond now_from_it = Eigen::Quaterniond::Identity();
    bool is_unbroken = true;
  };
  std::map<std::string, Run> runs;
  std::vector<MeasuredRotation> rotations;
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    Run& run = runs[images[i].sequence];
    if (reconstruction.images[i].submap_from_camera) {
      if (run.from && run.is_unbroken) {
        rotations.push_back(
            {*run.from, i, run.now_from_it, Seconds(images[i].time - images[*run.from].time)});
      }
      run = {i};
    }
    if (next_from_this[i]) {
      run.now_from_it = *next_from_this[i] * run.now_from_it;
    } else {
      run.is_unbroken = false;
    }
  }
  return rotations;
}

Result<VerificationEvidence> PruneAndVerify(BuiltSubmap& submap,
                                            const VerificationOptions& options) {
  WAYMARK_TRY_ASSIGN(
      const auto implausible,
      FindImplausibleImages(submap.reconstruction, submap.images, submap.Rotations(), options));
  RemoveImages(implausible, submap.reconstruction);
  return VerifyReconstruction(submap.reconstruction, submap.images, submap.Rotations(), options);
}

PoseErrors CompareWithTruth(const BuiltSubmap& submap) {
  constexpr double kWrongM = 0.3;
  constexpr double kWrongRad = 0.01745;
  Trajectory estimate, truth;
  for (std::size_t i = 0; i < submap.true_poses.size(); ++i) {
    const auto& pose = submap.reconstruction.images[i].submap_from_camera;
    if (!pose) continue;
    const std::string name = fmt::format("{:06}", i);
    estimate[name] = Rigid3(pose->rotation(), pose->translation());
    truth[name] = submap.true_poses[i];
  }
  PoseErrors errors{.images = static_cast<int>(estimate.size())};
  Trajectory agreeing = estimate;
  std::vector<double> metres, radians;
  for (int iteration = 0; iteration < 6; ++iteration) {
    const auto truth_from_estimate = EstimateAlignment(agreeing, truth);
    if (!truth_from_estimate) return errors;
    const Eigen::Vector3d up = truth_from_estimate->rotation() * Eigen::Vector3d::UnitZ();
    errors.lean_rad = std::atan2(up.head<2>().norm(), up.z());
    metres.clear();
    radians.clear();
    errors.wrong = 0;
    std::map<std::string, double> off;
    for (const auto& [name, pose] : estimate) {
      const Rigid3 moved = CarryPose(*truth_from_estimate, pose);
      metres.push_back((moved.translation() - truth[name].translation()).norm());
      radians.push_back(AngleBetween(moved.rotation(), truth[name].rotation()).radians());
      errors.wrong += metres.back() > kWrongM || radians.back() > kWrongRad;
      off[name] = metres.back();
    }
    std::vector<double> sorted = metres;
    std::ranges::sort(sorted);
    const double limit = std::max(kWrongM, 2.5 * sorted[sorted.size() / 2]);
    agreeing.clear();
    for (const auto& [name, pose] : estimate) {
      if (off[name] <= limit) agreeing[name] = pose;
    }
  }
  std::ranges::sort(metres);
  std::ranges::sort(radians);
  errors.p90_m = metres[9 * metres.size() / 10];
  errors.p90_rad = radians[9 * radians.size() / 10];
  return errors;
}

}  // namespace waymark::evaluation

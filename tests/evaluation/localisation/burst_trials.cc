// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/burst_trials.h"

#include <numeric>
#include <utility>

#include "mapping/experience/kapture.h"
#include "tests/evaluation/data.h"
#include "tests/evaluation/localisation/summaries.h"
#include "tests/evaluation/localisation/true_pose_map.h"
#include "tests/evaluation/running.h"

namespace waymark::evaluation {
namespace {

mapping::ImageFeatures Chosen(const mapping::ImageFeatures& all,
                              const std::vector<std::size_t>& indices) {
  mapping::ImageFeatures some;
  for (const std::size_t i : indices) {
    some.keypoints.push_back(all.keypoints[i]);
    some.descriptors.push_back(all.descriptors[i]);
  }
  return some;
}

/// How the truth's camera is turned against the one that took the pictures: 0.2 degrees between
/// KITTI's calibrations, which mapped images show and which is no error of those that are asked.
Eigen::Quaterniond TruthFromPictures(const Trajectory& map_from_camera, const Trajectory& truth,
                                     const Sim3& truth_from_map) {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (const auto& [name, pose] : map_from_camera) {
    turn += VectorFromRotation(truth.at(name).rotation().conjugate() *
                               CarryPose(truth_from_map, pose).rotation());
  }
  return RotationFromVector(turn / static_cast<double>(map_from_camera.size()));
}

Result<std::vector<AskedFrame>> LoadFrames(const std::filesystem::path& asked,
                                           const Trajectory& truth, const Sim3& truth_from_map,
                                           const Eigen::Quaterniond& truth_from_pictures) {
  WAYMARK_TRY_ASSIGN(const auto experience, mapping::LoadKapture(asked));
  std::vector<AskedFrame> frames;
  for (const mapping::ImageRecord& record : experience.images) {
    WAYMARK_TRY_ASSIGN(const auto image, LoadGrayPicture(experience.ImagePath(record)));
    const localiser::LocaliserOptions options;
    WAYMARK_TRY_ASSIGN(auto features, mapping::ExtractFeatures(image, options.features));
    const Rigid3& recorded = truth.at(record.name);
    const Rigid3 world_from_camera(recorded.rotation() * truth_from_pictures,
                                   recorded.translation());
    frames.push_back({experience.cameras.at(record.camera).model, std::move(features),
                      world_from_camera, CarryPose(truth_from_map.Inverse(), world_from_camera)});
  }
  return frames;
}

}  // namespace

Result<AskedDrive> PrepareAskedDrive(const std::filesystem::path& drive,
                                     const std::filesystem::path& scratch) {
  const auto mapped = scratch / "mapped", asked = scratch / "asked", folder = scratch / "map";
  const auto even = [](std::size_t i, const std::string&) { return i % 2 == 0; };
  const auto odd = [](std::size_t i, const std::string&) { return i % 2 == 1; };
  WAYMARK_TRY(StoreKaptureSubset(drive, mapped, even));
  WAYMARK_TRY(StoreKaptureSubset(drive, asked, odd));
  WAYMARK_TRY(RunProgram(ExecutableFolder() / "waymark-map",
                         {"add", folder.string(), mapped.string(), "--quiet"}, scratch / "log"));
  WAYMARK_TRY_ASSIGN(const auto truth, LoadTumTrajectory(drive / "truth.tum"));
  WAYMARK_TRY_ASSIGN(const auto poses, LoadMapPoses(folder));
  WAYMARK_TRY_ASSIGN(const Sim3 truth_from_map, EstimateAlignment(poses.map_from_camera, truth));
  WAYMARK_TRY_ASSIGN(auto map, mapping::MapDirectory::Open(folder));
  WAYMARK_TRY_ASSIGN(auto release, map.LoadCurrentRelease());
  WAYMARK_TRY_ASSIGN(auto frames,
                     LoadFrames(asked, truth, truth_from_map,
                                TruthFromPictures(poses.map_from_camera, truth, truth_from_map)));
  return AskedDrive{drive.filename().string(), std::move(map), std::move(release),
                    std::move(frames)};
}

Result<AskedDrive> Summarised(AskedDrive drive, std::size_t max_bytes) {
  WAYMARK_TRY_ASSIGN(auto submaps, StoreSummaries(drive.map, drive.release.submaps, max_bytes));
  drive.release = ReleaseOf(std::move(submaps));
  return drive;
}

Starve Strip(double share) {
  return [share](const mapping::ImageFeatures& features, const CameraModel& camera,
                 simulator::Random& random) {
    const double left_px = random.Uniform(0, (1 - share) * camera.width_px());
    std::vector<std::size_t> inside;
    for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
      const double x_px = features.keypoints[i].x_px;
      if (x_px >= left_px && x_px < left_px + share * camera.width_px()) inside.push_back(i);
    }
    return Chosen(features, inside);
  };
}

Starve Some(std::size_t count) {
  return [count](const mapping::ImageFeatures& features, const CameraModel&,
                 simulator::Random& random) {
    std::vector<std::size_t> order(features.keypoints.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const std::size_t kept = std::min(count, order.size());
    for (std::size_t i = 0; i < kept; ++i) {
      const double at = random.Uniform(0, static_cast<double>(order.size() - i));
      std::swap(order[i], order[std::min(order.size() - 1, i + static_cast<std::size_t>(at))]);
    }
    order.resize(kept);
    return Chosen(features, order);
  };
}

std::vector<Verdict> AskBursts(const localiser::Localiser& localiser, const AskedDrive& drive,
                               const BurstTrial& trial, std::size_t longest,
                               const Parallelism& parallelism) {
  const std::size_t frames = drive.frames.size();
  if (frames < longest) return {};
  const std::size_t asked = frames - longest + 1;
  std::vector<Verdict> verdicts(asked * static_cast<std::size_t>(trial.repeats));
  ParallelFor(verdicts.size(), parallelism, [&](std::size_t v) {
    const std::size_t last = longest - 1 + v % asked;
    localiser::BurstRequest burst;
    for (std::size_t i = last + 1 - trial.images; i <= last; ++i) {
      const AskedFrame& frame = drive.frames[i];
      simulator::Random random(1000 * (v / asked) + i);  // a frame is the same in every burst
      const Rigid3& there = frame.world_from_camera;
      burst.images.push_back(
          {{trial.starve ? trial.starve(frame.features, frame.camera, random) : frame.features,
            frame.camera, std::nullopt,
            Eigen::Vector3d(there.rotation().conjugate() * Eigen::Vector3d::UnitZ())},
           {there.rotation(), trial.odometry_scale * there.translation()}});
    }
    const Question question{drive.name, burst.images.back().request,
                            drive.frames[last].map_from_camera};
    verdicts[v] = Judge(question, trial.images == 1 ? localiser.Localise(question.request)
                                                    : localiser.Localise(burst));
  });
  return verdicts;
}

}  // namespace waymark::evaluation

// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/task_input.h"

#include <algorithm>
#include <map>
#include <unordered_map>
#include <utility>

#include "mapping/base/file.h"
#include "mapping/features/feature_codec.h"
#include "mapping/pipeline/internal/planning.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

/// The indexes of all experiences of a task, with their images by name.
struct Lender {
  ExperienceIndex index;
  std::uint32_t group = 0;
  std::uint32_t first_camera = 0;
  std::unordered_map<std::string, std::size_t> image_by_name = {};
  std::vector<GyroscopeChain> chains = {};  ///< by image
};

/// Images of one camera follow each other in time; the index is sorted.
std::vector<GyroscopeChain> ChainRotations(const ExperienceIndex& index) {
  std::vector<GyroscopeChain> chains(index.images.size());
  std::map<std::uint32_t, GyroscopeChain> next_of_camera;
  std::uint32_t chain_count = 0;
  for (std::size_t i = 0; i < chains.size(); ++i) {
    const auto [next, is_new] = next_of_camera.try_emplace(index.images[i].camera);
    if (is_new) next->second.chain = chain_count++;
    chains[i] = next->second;
    if (const auto& next_from_this = index.images[i].next_from_this) {
      next->second.now_from_start = *next_from_this * chains[i].now_from_start;
    } else {
      next->second = GyroscopeChain{chain_count++, Eigen::Quaterniond::Identity()};
    }
  }
  return chains;
}

double ReadoutOf(const std::string& camera, const PipelineOptions& options) {
  auto found = options.readout_s.find(camera);
  if (found == options.readout_s.end()) found = options.readout_s.find("");
  return found != options.readout_s.end() ? found->second : 0;
}

Result<std::map<ExperienceId, Lender>> LoadLenders(const MapDirectory& map, const SubmapTask& task,
                                                   TaskInput& input) {
  std::map<ExperienceId, Lender> lenders;
  for (const auto& [id, content] : task.contents) {
    WAYMARK_TRY_ASSIGN(ExperienceIndex index, LoadIndex(map.ExperienceFolder(id)));
    Lender lender{.index = std::move(index)};
    if (lender.index.content != content) {
      return MakeError(ErrorCode::kConflict, "experience {}: changed since the submap was planned",
                       id.text());
    }
    lender.group = static_cast<std::uint32_t>(lenders.size());
    lender.first_camera = static_cast<std::uint32_t>(input.cameras.size());
    for (const CameraSensor& camera : lender.index.cameras) {
      input.cameras.push_back({.model = camera.model,
                               .has_known_focal = camera.has_known_focal,
                               .readout_s = ReadoutOf(camera.id, task.options)});
    }
    for (std::size_t i = 0; i < lender.index.images.size(); ++i) {
      lender.image_by_name[lender.index.images[i].name] = i;
    }
    lender.chains = ChainRotations(lender.index);
    lenders.emplace(id, std::move(lender));
  }
  return lenders;
}

Result<ImageFeatures> LoadFeatures(const fs::path& path) {
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(path));
  auto features = DecodeFeatures(bytes);
  if (!features) {
    return Error{features.error().code, path.string() + ": " + features.error().message};
  }
  return features;
}

Result<void> LoadAllFeatures(const MapDirectory& map, const Parallelism& parallelism,
                             TaskInput& input) {
  std::vector<Result<ImageFeatures>> loaded(input.images.size());
  ParallelFor(loaded.size(), parallelism, [&](std::size_t i) {
    const fs::path folder = map.ExperienceFolder(input.task.images[i].experience);
    loaded[i] = LoadFeatures(FeaturePath(folder, input.images[i].features));
  });
  for (auto& features : loaded) {
    WAYMARK_TRY_ASSIGN(ImageFeatures taken, std::move(features));
    input.features.push_back(std::move(taken));
  }
  return {};
}

/// Only cameras that took an image: the others would be parameters nothing determines.
void DropUnusedCameras(TaskInput& input) {
  std::vector<std::optional<std::uint32_t>> new_index(input.cameras.size());
  std::vector<SfmCamera> used;
  for (std::uint32_t& camera : input.camera_of_image) {
    if (!new_index[camera]) {
      new_index[camera] = static_cast<std::uint32_t>(used.size());
      used.push_back(input.cameras[camera]);
    }
    camera = *new_index[camera];
  }
  input.cameras = std::move(used);
}

}  // namespace

Result<TaskInput> LoadTaskInput(const MapDirectory& map, const fs::path& folder,
                                const std::string& task, const Parallelism& parallelism) {
  WAYMARK_TRY_ASSIGN(SubmapTask decoded, LoadTask(folder, task));
  TaskInput input{.task = std::move(decoded), .uses_gnss = map.description().is_geo_aligned};
  WAYMARK_TRY_ASSIGN(const auto lenders, LoadLenders(map, input.task, input));
  for (const TaskImage& image : input.task.images) {
    const auto lender = lenders.find(image.experience);
    if (lender == lenders.end() || !lender->second.image_by_name.contains(image.name)) {
      return MakeError(ErrorCode::kNotFound, "{}: image {} of experience {} is not in the map",
                       TaskPath(folder, task).string(), image.name, image.experience.text());
    }
    const Lender& from = lender->second;
    const std::size_t position = from.image_by_name.at(image.name);
    const IndexedImage& indexed = from.index.images[position];
    input.images.push_back(indexed);
    input.chains.push_back(from.chains[position]);
    input.camera_of_image.push_back(from.first_camera + indexed.camera);
    input.group_of_image.push_back(from.group);
    input.mounts.push_back(from.index.mounts[indexed.camera]);
    if (auto& mount = input.mounts.back()) mount->rig = image.experience.text() + "/" + mount->rig;
    input.sequences.push_back(image.experience.text() + "/" +
                              from.index.cameras[indexed.camera].id);
  }
  WAYMARK_TRY(LoadAllFeatures(map, parallelism, input));
  DropUnusedCameras(input);
  return input;
}

std::vector<MeasuredRotation> ComposeRotations(const TaskInput& input,
                                               const Reconstruction& reconstruction) {
  std::map<std::string, std::vector<std::uint32_t>> sequences;
  for (std::uint32_t i = 0; i < input.images.size(); ++i) {
    sequences[input.sequences[i]].push_back(i);
  }
  std::vector<MeasuredRotation> rotations;
  for (auto& [sequence, images] : sequences) {
    std::stable_sort(images.begin(), images.end(), [&](std::uint32_t a, std::uint32_t b) {
      return input.images[a].time < input.images[b].time;
    });
    std::optional<std::uint32_t> from;
    for (const std::uint32_t to : images) {
      if (!reconstruction.images[to].submap_from_camera) continue;
      if (from && input.chains[*from].chain == input.chains[to].chain) {
        rotations.push_back(
            {*from, to,
             input.chains[to].now_from_start * input.chains[*from].now_from_start.conjugate(),
             Seconds(input.images[to].time - input.images[*from].time)});
      }
      from = to;
    }
  }
  return rotations;
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/indexing.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"
#include "mapping/features/feature_codec.h"
#include "mapping/pipeline/internal/image_sensing.h"
#include "mapping/pipeline/internal/options_codec.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

/// What became of one image of the recording.
struct ImageOutcome {
  std::string content;
  std::string features;          ///< file stem; empty when the image is unusable
  std::string unusable;          ///< why
  std::optional<Error> failure;  ///< of storage: ends the run
};

bool HasFeatures(const fs::path& path) {
  const auto bytes = LoadFile(path);
  return bytes.ok() && DecodeFeatures(*bytes).ok();  // a damaged file is made again
}

/// Features of one image, from the cache or the pixels.
ImageOutcome TakeImage(const fs::path& image_path, const fs::path& folder,
                       const FeatureOptions& options, const std::string& options_hash) {
  ImageOutcome outcome;
  const auto bytes = LoadFile(image_path);
  if (!bytes) {
    outcome.failure = bytes.error();
    return outcome;
  }
  outcome.content = ContentHash(*bytes);
  outcome.features = ContentHash(outcome.content + options_hash);
  const fs::path path = FeaturePath(folder, outcome.features);
  if (HasFeatures(path)) return outcome;

  const auto pixels = DecodeGrayImage(*bytes);
  const auto features =
      pixels ? ExtractFeatures(*pixels, options) : Result<ImageFeatures>(pixels.error());
  if (!features) {
    outcome.features.clear();
    outcome.unusable = ToString(features.error());
    return outcome;
  }
  if (auto stored = StoreFileAtomically(path, EncodeFeatures(*features)); !stored) {
    outcome.failure = stored.error();
  }
  return outcome;
}

std::optional<CameraMount> FindMount(const Experience& experience, const std::string& camera) {
  const auto member = std::ranges::find(experience.rigs, camera, &RigMember::sensor);
  if (member == experience.rigs.end()) return std::nullopt;
  return CameraMount{member->rig, member->sensor_from_rig};
}

/// The hash of all sensor tables, as they are on disk, and all images.
Result<std::string> CombineContent(const Experience& experience,
                                   std::span<const std::string> image_contents) {
  const fs::path folder = experience.folder / "sensors";
  WAYMARK_TRY_ASSIGN(const std::vector<std::string> names, ListFolder(folder));
  std::string text;
  for (const std::string& name : names) {
    if (fs::path(name).extension() != ".txt") continue;
    WAYMARK_TRY_ASSIGN(const std::string content, LoadTextFile(folder / name));
    text += fmt::format("{} {}\n", name, ContentHash(std::string_view(content)));
  }
  for (std::size_t i = 0; i < image_contents.size(); ++i) {
    text += fmt::format("{} {}\n", experience.images[i].name, image_contents[i]);
  }
  return ContentHash(std::string_view(text));
}

Result<std::vector<ImageOutcome>> TakeImages(const Experience& experience, const fs::path& folder,
                                             const FeatureOptions& options,
                                             const Parallelism& parallelism, Run& run) {
  WAYMARK_TRY(CreateFolders(folder / "features"));
  const std::string options_hash = HashFeatureOptions(options);
  std::vector<ImageOutcome> outcomes(experience.images.size());
  StageCounter counter(run, PipelineStage::kFeatures, experience.id.text(), outcomes.size());
  ParallelFor(outcomes.size(), parallelism, [&](std::size_t i) {
    if (run.ShouldStop()) return;
    outcomes[i] =
        TakeImage(experience.ImagePath(experience.images[i]), folder, options, options_hash);
    counter.Add();
  });
  if (run.ShouldStop()) return Run::Stopped();
  for (const ImageOutcome& outcome : outcomes) {
    if (outcome.failure) return *outcome.failure;
  }
  return outcomes;
}

/// A picture that is the one before to the byte was not taken again: no two are without noise. A
/// camera that hangs would put the vehicle where it was a while ago.
void MarkRepeated(const Experience& experience, std::vector<ImageOutcome>& outcomes) {
  std::map<std::string, std::size_t> last_of_camera;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const auto [last, is_first] = last_of_camera.try_emplace(experience.images[i].camera, i);
    const std::size_t before = std::exchange(last->second, i);
    if (is_first || outcomes[i].content != outcomes[before].content) continue;
    outcomes[i].features.clear();
    outcomes[i].unusable =
        fmt::format("the same picture as {}: the camera hangs", experience.images[before].name);
  }
}

}  // namespace

Result<std::string> HashRecording(const Experience& experience, const Parallelism& parallelism,
                                  Run& run) {
  std::vector<Result<std::string>> hashes(experience.images.size());
  ParallelFor(hashes.size(), parallelism, [&](std::size_t i) {
    if (run.ShouldStop()) return;
    const auto bytes = LoadFile(experience.ImagePath(experience.images[i]));
    hashes[i] = bytes ? Result<std::string>(ContentHash(*bytes)) : bytes.error();
  });
  if (run.ShouldStop()) return Run::Stopped();
  std::vector<std::string> contents;
  for (auto& hash : hashes) {
    WAYMARK_TRY_ASSIGN(std::string content, std::move(hash));
    contents.push_back(std::move(content));
  }
  return CombineContent(experience, contents);
}

Result<ExperienceIndex> IndexExperience(const Experience& experience, const TangentPlane& map,
                                        const fs::path& folder, const FeatureOptions& options,
                                        const Parallelism& parallelism, Run& run) {
  WAYMARK_TRY_ASSIGN(std::vector<ImageOutcome> outcomes,
                     TakeImages(experience, folder, options, parallelism, run));
  ExperienceIndex index{.id = experience.id, .features = HashFeatureOptions(options)};
  std::vector<std::string> contents;
  for (const ImageOutcome& outcome : outcomes) contents.push_back(outcome.content);
  WAYMARK_TRY_ASSIGN(index.content, CombineContent(experience, contents));

  std::map<std::string, std::uint32_t> camera_index;
  for (const auto& [id, camera] : experience.cameras) {
    camera_index[id] = static_cast<std::uint32_t>(index.cameras.size());
    index.cameras.push_back(camera);
    index.mounts.push_back(FindMount(experience, id));
  }
  MarkRepeated(experience, outcomes);
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const ImageRecord& record = experience.images[i];
    if (outcomes[i].features.empty()) {
      index.unusable.push_back({record.name, outcomes[i].unusable});
      continue;
    }
    index.images.push_back({.name = record.name,
                            .time = record.time,
                            .camera = camera_index.at(record.camera),
                            .features = outcomes[i].features});
  }
  if (index.images.empty()) {
    return MakeError(ErrorCode::kCorrupt, "experience {}: none of its {} images is usable; {}: {}",
                     experience.id.text(), outcomes.size(),
                     index.unusable.empty() ? "" : index.unusable.front().name,
                     index.unusable.empty() ? "" : index.unusable.front().reason);
  }
  SenseImages(experience, map, index.images);
  WAYMARK_TRY(StoreFileAtomically(IndexPath(folder), std::string_view(EncodeIndex(index))));
  // From disk, so that this run and one that resumes it see the same rounding.
  return LoadIndex(folder);
}

}  // namespace waymark::mapping

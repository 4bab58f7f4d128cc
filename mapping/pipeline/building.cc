// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/building.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/base/file.h"
#include "mapping/base/stopwatch.h"
#include "mapping/io/submap_file.h"
#include "mapping/matching/image_matcher.h"
#include "mapping/pipeline/internal/rig_links.h"
#include "mapping/pipeline/internal/task_input.h"
#include "mapping/submap/prune.h"

namespace waymark::mapping {
namespace {

std::string ShortName(const std::string& task) { return task.substr(0, 8); }

std::vector<ImagePair> SelectPairs(const TaskInput& input, const TangentPlane& submap_plane) {
  std::vector<PairingImage> images;
  for (std::size_t i = 0; i < input.images.size(); ++i) {
    const IndexedImage& image = input.images[i];
    PairingImage pairing{.sequence = input.sequences[i],
                         .time = image.time,
                         .gnss_in_map = {},
                         .descriptors = input.features[i].descriptors};
    if (image.gnss && input.uses_gnss) pairing.gnss_in_map = submap_plane.ToMap(*image.gnss);
    images.push_back(std::move(pairing));
  }
  return SelectCandidatePairs(images, input.task.options.pairing);
}

Result<std::vector<PairMatches>> MatchPairs(const TaskInput& input,
                                            const std::vector<ImagePair>& pairs,
                                            const std::string& name, const Parallelism& parallelism,
                                            Run& run) {
  std::vector<std::span<const Descriptor>> descriptors;
  for (const ImageFeatures& features : input.features) descriptors.push_back(features.descriptors);
  const PipelineOptions& options = input.task.options;
  const ImageMatcher matcher(std::move(descriptors), options.matching, options.search, parallelism);
  std::vector<PairMatches> matches(pairs.size());
  StageCounter counter(run, PipelineStage::kMatching, name, pairs.size());
  ParallelFor(pairs.size(), parallelism, [&](std::size_t i) {
    if (run.ShouldStop()) return;
    matches[i] = {pairs[i], matcher.Match(pairs[i])};
    counter.Add();
  });
  if (run.ShouldStop()) return Run::Stopped();
  std::erase_if(matches, [](const PairMatches& match) { return match.matches.empty(); });
  return matches;
}

std::vector<SfmImage> MakeSfmImages(const TaskInput& input, const TangentPlane& submap_plane) {
  std::vector<SfmImage> images;
  for (std::size_t i = 0; i < input.images.size(); ++i) {
    const IndexedImage& image = input.images[i];
    SfmImage sfm{.camera = input.camera_of_image[i],
                 .keypoints = input.features[i].keypoints,
                 .gnss_in_submap = {},
                 .gnss_sigma_m = image.gnss_sigma_m,
                 .up_in_camera = image.up_in_camera,
                 .group = input.group_of_image[i],
                 .time_s = Seconds(image.time.time_since_epoch())};
    if (image.gnss && input.uses_gnss) {
      sfm.gnss_in_submap = Point<Submap>(submap_plane.ToMap(*image.gnss).coordinates());
    }
    images.push_back(std::move(sfm));
  }
  return images;
}

/// Takes out single images that cannot be right, then judges the rest.
Result<VerificationEvidence> PruneAndVerify(const TaskInput& input,
                                            std::span<const SfmImage> sfm_images,
                                            Reconstruction& reconstruction) {
  std::vector<VerificationImage> images;
  for (std::size_t i = 0; i < input.images.size(); ++i) {
    images.push_back({.sequence = input.sequences[i],
                      .time = input.images[i].time,
                      .up_in_camera = input.images[i].up_in_camera,
                      .gnss_in_submap = sfm_images[i].gnss_in_submap,
                      .gnss_sigma_m = sfm_images[i].gnss_sigma_m,
                      .is_borrowed = input.task.images[i].is_borrowed});
  }
  const VerificationOptions& options = input.task.options.verification;
  WAYMARK_TRY_ASSIGN(const auto implausible,
                     FindImplausibleImages(reconstruction, images,
                                           ComposeRotations(input, reconstruction), options));
  RemoveImages(implausible, reconstruction);
  return VerifyReconstruction(reconstruction, images, ComposeRotations(input, reconstruction),
                              options);
}

Result<SubmapModel> Assemble(const TaskInput& input, const Reconstruction& reconstruction,
                             const VerificationEvidence& evidence) {
  std::vector<AssemblyImage> images;
  for (std::size_t i = 0; i < input.images.size(); ++i) {
    const TaskImage& named = input.task.images[i];
    images.push_back({.experience = named.experience,
                      .name = named.name,
                      .features = &input.features[i],
                      .gnss = input.uses_gnss ? input.images[i].gnss : std::nullopt,
                      .gnss_sigma_m = input.images[i].gnss_sigma_m,
                      .is_borrowed = named.is_borrowed});
  }
  return AssembleSubmap(reconstruction, images, input.task.origin, evidence,
                        input.task.options.assembly);
}

/// Why each of the task's own images is not in the map. An empty reason: it is.
void ListLeftOut(const TaskInput& input, const Reconstruction* reconstruction, bool is_accepted,
                 Decision& decision) {
  for (std::size_t i = 0; i < input.images.size(); ++i) {
    const TaskImage& image = input.task.images[i];
    if (image.is_borrowed) continue;
    std::string reason;
    if (reconstruction != nullptr && !reconstruction->images[i].submap_from_camera) {
      reason = reconstruction->images[i].exclusion;
    } else if (!is_accepted) {
      reason = "its submap was " + decision.verdict;
    } else {
      continue;
    }
    decision.left_out.push_back({image.experience, image.name, reason});
  }
}

/// From matches to a decision; an accepted submap is stored.
Result<Decision> Reconstruct(const MapDirectory& map, const TaskInput& input,
                             const TangentPlane& submap_plane,
                             const std::vector<PairMatches>& matches, const std::string& name,
                             const Parallelism& parallelism, Run& run) {
  const std::vector<SfmImage> images = MakeSfmImages(input, submap_plane);
  SfmOptions options = input.task.options.sfm;
  options.parallelism = parallelism;
  const auto on_progress = [&](std::string_view, double share) {
    run.Report(PipelineStage::kReconstruction, name,
               static_cast<std::size_t>(std::lround(1000 * std::clamp(share, 0.0, 1.0))), 1000);
  };
  Stopwatch watch;
  auto reconstruction = ReconstructIncrementally(input.cameras, images, matches, options,
                                                 on_progress, LinkRigs(input));
  Decision decision;
  decision.times.reconstruction_s = watch.Lap();
  if (!reconstruction) {
    decision.verdict = "rejected: " + reconstruction.error().message;
    ListLeftOut(input, nullptr, false, decision);
    return decision;
  }
  WAYMARK_TRY_ASSIGN(const VerificationEvidence evidence,
                     PruneAndVerify(input, images, *reconstruction));
  decision.verdict = evidence.verdict;
  decision.figures = evidence.figures;
  ListLeftOut(input, &*reconstruction, evidence.accepted, decision);
  WAYMARK_TRY_ASSIGN(const SubmapModel model, Assemble(input, *reconstruction, evidence));
  decision.images = static_cast<int>(model.images.size());
  decision.landmarks = static_cast<int>(model.landmarks.size());
  if (evidence.accepted) {
    WAYMARK_TRY_ASSIGN(const auto bytes, EncodeSubmap(model));
    WAYMARK_TRY_ASSIGN(decision.submap, map.StoreSubmap(bytes));
  }
  decision.times.verification_s = watch.Lap();
  return decision;
}

}  // namespace

SubmapReport ReportOf(const std::string& task, const Decision& decision, bool was_built_before) {
  return {.task = task,
          .id = decision.submap,
          .was_built_before = was_built_before,
          .verdict = decision.verdict,
          .images = decision.images,
          .landmarks = decision.landmarks};
}

Result<SubmapReport> BuildTask(const MapDirectory& map, const ExperienceId& experience,
                               const std::string& task, const Parallelism& parallelism, Run& run) {
  const std::filesystem::path folder = map.ExperienceFolder(experience);
  WAYMARK_TRY_ASSIGN(const std::optional<Decision> done, LoadDecision(folder, task));
  if (done) return ReportOf(task, *done, true);

  Stopwatch watch;
  const std::string name = ShortName(task);
  WAYMARK_TRY_ASSIGN(const TaskInput input, LoadTaskInput(map, folder, task, parallelism));
  const TangentPlane submap_plane(input.task.origin);
  WAYMARK_TRY_ASSIGN(const auto matches,
                     MatchPairs(input, SelectPairs(input, submap_plane), name, parallelism, run));
  const double matching_s = watch.Lap();
  WAYMARK_TRY_ASSIGN(Decision decision,
                     Reconstruct(map, input, submap_plane, matches, name, parallelism, run));
  decision.times.matching_s = matching_s;
  decision.times.matching_threads = static_cast<int>(parallelism.ThreadCount());
  WAYMARK_TRY(
      StoreFileAtomically(DecisionPath(folder, task), std::string_view(EncodeDecision(decision))));
  return ReportOf(task, decision, false);
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/base/parallel.h"
#include "mapping/base/result.h"
#include "mapping/features/features.h"
#include "mapping/fusion/fusion.h"
#include "mapping/matching/candidate_pairs.h"
#include "mapping/matching/descriptor_matching.h"
#include "mapping/matching/image_matcher.h"
#include "mapping/sfm/incremental.h"
#include "mapping/split/split.h"
#include "mapping/submap/assemble.h"
#include "mapping/submap/verify.h"

namespace waymark::mapping {

/// Every number of the way from experiences to a release, by stage.
struct PipelineOptions {
  FeatureOptions features = {};
  SplitOptions split = {};
  PairingOptions pairing = {};
  MatchOptions matching = {};
  SearchOptions search = {};  ///< of descriptors
  SfmOptions sfm = {};  ///< its parallelism is set by the pipeline
  VerificationOptions verification = {};
  AssemblyOptions assembly = {};
  /// Seconds that rolling shutters take from the first row to the last, by camera; "" is every
  /// camera that is not named. Image times are those of the middle row.
  std::map<std::string, double> readout_s = {};
  FusionOptions fusion = {};     ///< its parallelism is set by the pipeline
  Parallelism parallelism = {};  ///< for everything; never changes what is in a map

  Result<void> Validate() const;
};

enum class PipelineStage { kFeatures, kMatching, kReconstruction, kSubmaps, kFusion };

/// "features", "matching", …
std::string_view PipelineStageName(PipelineStage stage);

/// What is being done. `done` counts up to `total` in units of the stage: images, image pairs,
/// thousandths of a reconstruction, submaps.
struct PipelineProgress {
  PipelineStage stage;
  std::string subject;  ///< experience or submap
  std::size_t done = 0;
  std::size_t total = 0;
};

/// How a caller watches and stops a run. Both are called from several threads, one at a time.
struct PipelineObserver {
  std::function<void(const PipelineProgress&)> on_progress = {};
  /// Asked between images and submaps; true ends the run with Unavailable. What is finished stays.
  std::function<bool()> should_stop = {};
};

/// An image that is not in the map, and why.
struct LeftOutImage {
  ExperienceId experience;
  std::string name;
  std::string reason;
};

/// What became of one subset.
struct SubmapReport {
  std::string task;               ///< for `waymark-map build-submap`
  std::optional<SubmapId> id;     ///< absent: rejected
  bool was_built_before = false;  ///< by an earlier run
  std::string verdict = {};
  int images = 0;  ///< registered, borrowed ones included
  int landmarks = 0;
};

struct AddReport {
  std::vector<ExperienceId> added;
  std::vector<ExperienceId> already_in_map;  ///< with the same content; left alone
  std::vector<ExperienceId> rejected;        ///< none of their submaps was accepted
  std::vector<SubmapReport> submaps;         ///< of the experiences that are not in the map already
  std::vector<LeftOutImage> left_out;        ///< images of theirs that no accepted submap holds
  std::vector<SubmapId> unplaced;            ///< accepted, but fusion knows no place for them
  std::optional<std::uint64_t> epoch;        ///< absent: there is no new release
  std::optional<std::string> resumes_in;     ///< the Slurm job that goes on with this run
  double overlap_rms_m = 0;                  ///< over the release's submaps that share images
  double gnss_rms_m = 0;
  bool is_geo_aligned = true;
};

/// How far to go: `kPlan` ends after planning, for schedulers that build submaps elsewhere;
/// `kCandidate` stores the release and leaves the live one live.
enum class AddUntil { kPlan, kCandidate, kRelease };

/// How often an experience's submaps were submitted to a cluster by runs before this one.
struct SlurmRounds {
  ExperienceId experience;
  int done = 0;
};

/// Building submaps on a cluster. Map directory and program are seen under the same paths by this
/// machine and by all nodes.
struct SlurmOptions {
  std::filesystem::path program = {};       ///< waymark-map, absolute
  std::vector<std::string> arguments = {};  ///< for sbatch: partition, memory, time limit, …
  int threads = 1;                          ///< of a submap; features are found by the caller
  int rounds = 3;                           ///< how often a task is tried
  std::chrono::milliseconds poll{2000};
  /// Absent: the run waits for its jobs. Present: it ends when the jobs of one experience are
  /// submitted, and a job that runs these words goes on once they have ended.
  std::function<std::vector<std::string>(const SlurmRounds&)> resume = {};
  std::optional<SlurmRounds> before = {};  ///< when this run is such a job

  Result<void> Validate() const;
};

struct AddRequest {
  std::filesystem::path map_folder = {};
  std::vector<std::filesystem::path> experience_folders = {};
  PipelineOptions options = {};
  AddUntil until = AddUntil::kRelease;
  std::optional<SlurmOptions> slurm = {};  ///< absent: submaps are built by this process
  std::string created_utc = {};            ///< ISO 8601, of the release
};

/// Adds experiences to a map, creating it when it is absent, and deploys a new release of all that
/// is live and of the new submaps. The same again deploys what was left as a candidate. Everything finished is durable: a run that was killed continues where it was
/// and repeats no finished image and no finished submap. An experience that is in the map with the
/// same content is left alone.
/// Errors: those of LoadKapture and MapDirectory; InvalidArgument (options, no or equal folders);
/// Conflict (an experience of this name with other content, another writer); Corrupt when no
/// image of an experience is usable; Unavailable when stopped by the observer. Experiences that
/// cannot be reconstructed are a value: `AddReport::rejected`. With `slurm`, Unavailable also when
/// jobs end without a decision; the map is the same, byte for byte, as one built by this process.
/// A run that is resumed by a job makes no release: the last job of the chain does.
Result<AddReport> AddExperiences(const AddRequest& request, const PipelineObserver& observer = {});

/// Builds one planned submap and stores it with its decision; does nothing when that is done.
/// Needs no lock: any number of processes may build different or equal submaps of one map.
/// Errors: NotFound (no such map or task), those of the stages.
Result<SubmapReport> BuildSubmap(const std::filesystem::path& map_folder, const std::string& task,
                                 const Parallelism& parallelism,
                                 const PipelineObserver& observer = {});

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mapping/pipeline/build_times.h"
#include "mapping/pipeline/internal/experience_index.h"
#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

struct TaskImage {
  ExperienceId experience;
  std::string name;
  bool is_borrowed;
};

/// Everything that determines one submap: MAP/experiences/<id>/tasks/<task>.json. Its id is the
/// hash of the file.
struct SubmapTask {
  ExperienceId experience;
  GeoPoint origin = {};  ///< of the submap frame
  PipelineOptions options = {};
  std::map<ExperienceId, std::string> contents = {};  ///< hash of every experience that takes part
  std::vector<TaskImage> images = {};
};

/// What became of a task: <task>.decision.json beside it.
struct Decision {
  std::optional<SubmapId> submap;  ///< absent: rejected
  std::string verdict;
  int images = 0;
  int landmarks = 0;
  std::vector<LeftOutImage> left_out;            ///< of the task's images that are not borrowed
  std::vector<VerificationFigure> figures = {};  ///< all that was checked
  BuildTimes times = {};
};

/// MAP/experiences/<id>/plan.json: the submaps of one experience.
struct Plan {
  std::string options;  ///< hash of the options it was made with
  std::vector<std::string> tasks = {};
  std::vector<std::string> thinned_out = {};  ///< names of images in no task
};

/// Pure codecs. Decoding errors: Corrupt, Unsupported, with `name` as the object.
std::string EncodeTask(const SubmapTask& task);
Result<SubmapTask> DecodeTask(std::string_view json, std::string_view name);
std::string EncodeDecision(const Decision& decision);
Result<Decision> DecodeDecision(std::string_view json, std::string_view name);
std::string EncodePlan(const Plan& plan);
Result<Plan> DecodePlan(std::string_view json, std::string_view name);

inline std::filesystem::path PlanPath(const std::filesystem::path& folder) {
  return folder / "plan.json";
}
inline std::filesystem::path TaskPath(const std::filesystem::path& folder,
                                      const std::string& task) {
  return folder / "tasks" / (task + ".json");
}
inline std::filesystem::path DecisionPath(const std::filesystem::path& folder,
                                          const std::string& task) {
  return folder / "tasks" / (task + ".decision.json");
}

}  // namespace waymark::mapping

// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/membership.h"

#include <utility>

#include "mapping/base/file.h"
#include "mapping/pipeline/internal/planning.h"

namespace waymark::mapping {

namespace fs = std::filesystem;

Result<std::set<SubmapId>> LoadLiveSubmaps(const MapDirectory& map) {
  std::set<SubmapId> live;
  WAYMARK_TRY_ASSIGN(const auto epoch, map.LoadCurrentEpoch());
  if (!epoch) return live;
  WAYMARK_TRY_ASSIGN(const Release release, map.LoadRelease(*epoch));
  for (const ReleasedSubmap& submap : release.submaps) live.insert(submap.id);
  return live;
}

Result<std::set<SubmapId>> LoadReleasedSubmaps(const MapDirectory& map) {
  std::set<SubmapId> released;
  WAYMARK_TRY_ASSIGN(const auto epochs, map.ListReleaseEpochs());
  for (const std::uint64_t epoch : epochs) {
    WAYMARK_TRY_ASSIGN(const Release release, map.LoadRelease(epoch));
    for (const ReleasedSubmap& submap : release.submaps) released.insert(submap.id);
  }
  return released;
}

Result<std::vector<DecidedTask>> LoadDecisions(const fs::path& experience_folder) {
  constexpr std::string_view kEnding = ".decision.json";
  WAYMARK_TRY_ASSIGN(const std::vector<std::string> names, ListFolder(experience_folder / "tasks"));
  std::vector<DecidedTask> decided;
  for (const std::string& name : names) {
    if (name.starts_with('.') || !name.ends_with(kEnding)) continue;
    std::string task = name.substr(0, name.size() - kEnding.size());
    WAYMARK_TRY_ASSIGN(std::optional<Decision> decision, LoadDecision(experience_folder, task));
    if (decision) decided.push_back({std::move(task), *std::move(decision)});
  }
  return decided;
}

Result<std::set<SubmapId>> ListOwnSubmaps(const fs::path& experience_folder) {
  WAYMARK_TRY_ASSIGN(const auto decided, LoadDecisions(experience_folder));
  std::set<SubmapId> own;
  for (const DecidedTask& task : decided) {
    if (task.decision.submap) own.insert(*task.decision.submap);
  }
  return own;
}

}  // namespace waymark::mapping

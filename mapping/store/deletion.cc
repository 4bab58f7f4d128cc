// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/file.h"
#include "mapping/experience/names.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

/// What the folder of an experience is called while it is being deleted. No id begins with a dot.
constexpr std::string_view kDeletedPrefix = ".deleted.";

}  // namespace

Result<std::vector<SubmapId>> MapDirectory::ListSubmaps() const {
  WAYMARK_TRY_ASSIGN(std::vector<std::string> names, ListFolder(folder_ / "submaps"));
  std::vector<SubmapId> ids;
  for (std::string& name : names) {
    if (IsSubmapIdText(name)) ids.emplace_back(std::move(name));
  }
  return ids;
}

Result<std::vector<ExperienceId>> MapDirectory::ListExperiences() const {
  WAYMARK_TRY_ASSIGN(std::vector<std::string> names, ListFolder(folder_ / "experiences"));
  std::vector<ExperienceId> ids;
  for (std::string& name : names) {
    if (IsExperienceIdText(name)) ids.emplace_back(std::move(name));
  }
  return ids;
}

Result<void> MapDirectory::DeleteRelease(std::uint64_t epoch) const {
  WAYMARK_TRY_ASSIGN(const auto live, LoadCurrentEpoch());
  WAYMARK_TRY_ASSIGN(const auto epochs, ListReleaseEpochs());
  if (live == epoch || (!epochs.empty() && epochs.back() == epoch)) {
    return MakeError(ErrorCode::kConflict, "{}: epoch {} is the {} release and stays",
                     folder_.string(), epoch, live == epoch ? "live" : "newest");
  }
  return DeleteFile(ReleasePath(epoch));
}

Result<void> MapDirectory::DeleteSubmap(const SubmapId& id) const {
  return DeleteFile(SubmapPath(id));
}

Result<void> MapDirectory::DeleteExperienceFile(const ExperienceId& id,
                                                const fs::path& name) const {
  return DeleteFile(ExperienceFolder(id) / name);
}

Result<void> MapDirectory::DeleteExperience(const ExperienceId& id) const {
  const fs::path folder = ExperienceFolder(id);
  const fs::path doomed = folder.parent_path() / (std::string(kDeletedPrefix) + id.text());
  WAYMARK_TRY(DeleteFolder(doomed));  // of an earlier deletion that was cut short
  if (const auto renamed = RenameFolder(folder, doomed); !renamed) {
    if (renamed.error().code == ErrorCode::kNotFound) return {};
    return renamed.error();
  }
  return DeleteFolder(doomed);
}

Result<void> MapDirectory::FinishDeletions() const {
  const fs::path folder = folder_ / "experiences";
  WAYMARK_TRY_ASSIGN(const std::vector<std::string> names, ListFolder(folder));
  for (const std::string& name : names) {
    if (name.starts_with(kDeletedPrefix)) WAYMARK_TRY(DeleteFolder(folder / name));
  }
  return {};
}

}  // namespace waymark::mapping

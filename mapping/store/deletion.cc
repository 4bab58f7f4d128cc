// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "mapping/experience/names.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

/// What the folder of an experience is called while it is being deleted. No id begins with a dot.
constexpr std::string_view kDeletedPrefix = ".deleted.";

Error StorageError(const fs::path& path, std::string_view action, std::string_view reason) {
  return MakeError(ErrorCode::kUnavailable, "{}: cannot {}: {}", path.string(), action, reason);
}

/// Makes the removal or renaming of a folder's entries durable.
Result<void> SyncFolder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return StorageError(folder, "open folder", std::strerror(errno));
  const int outcome = ::fsync(descriptor);
  const int reason = errno;
  ::close(descriptor);
  if (outcome != 0) return StorageError(folder, "sync folder", std::strerror(reason));
  return {};
}

Result<void> DeleteFile(const fs::path& path) {
  if (::unlink(path.c_str()) != 0) {
    if (errno == ENOENT) return {};
    return StorageError(path, "delete", std::strerror(errno));
  }
  return SyncFolder(path.parent_path());
}

Result<void> DeleteFolder(const fs::path& path) {
  std::error_code failure;
  fs::remove_all(path, failure);
  if (failure) return StorageError(path, "delete", failure.message());
  return SyncFolder(path.parent_path());
}

Result<std::vector<std::string>> ListNames(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code failure;
  for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    names.push_back(entry->path().filename().string());
  }
  if (failure && failure != std::errc::no_such_file_or_directory) {
    return StorageError(folder, "read folder", failure.message());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

Result<std::vector<SubmapId>> MapDirectory::ListSubmaps() const {
  WAYMARK_TRY_ASSIGN(std::vector<std::string> names, ListNames(folder_ / "submaps"));
  std::vector<SubmapId> ids;
  for (std::string& name : names) {
    if (IsSubmapIdText(name)) ids.emplace_back(std::move(name));
  }
  return ids;
}

Result<std::vector<ExperienceId>> MapDirectory::ListExperiences() const {
  WAYMARK_TRY_ASSIGN(std::vector<std::string> names, ListNames(folder_ / "experiences"));
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
  std::error_code failure;
  fs::rename(folder, doomed, failure);
  if (failure == std::errc::no_such_file_or_directory) return {};
  if (failure) return StorageError(folder, "rename", failure.message());
  WAYMARK_TRY(SyncFolder(folder.parent_path()));
  return DeleteFolder(doomed);
}

Result<void> MapDirectory::FinishDeletions() const {
  const fs::path folder = folder_ / "experiences";
  WAYMARK_TRY_ASSIGN(const std::vector<std::string> names, ListNames(folder));
  for (const std::string& name : names) {
    if (name.starts_with(kDeletedPrefix)) WAYMARK_TRY(DeleteFolder(folder / name));
  }
  return {};
}

}  // namespace waymark::mapping

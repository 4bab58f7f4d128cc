// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/internal/imported_folder.h"

#include "mapping/base/file.h"
#include "mapping/experience/names.h"

namespace waymark::mapping::internal {
namespace {

namespace fs = std::filesystem;

bool IsInside(const fs::path& inner, const fs::path& outer) {
  const auto relative = inner.lexically_relative(outer);
  return !relative.empty() && *relative.begin() != "..";
}

}  // namespace

Result<void> PlaceImage(const fs::path& from, const fs::path& experience, const std::string& name) {
  const fs::path to = experience / "sensors" / "records_data" / name;
  WAYMARK_TRY(CreateFolders(to.parent_path()));
  std::error_code failure;
  fs::remove(to, failure);  // left by an import that was cut short
  const fs::path file = fs::weakly_canonical(from, failure);  // of a link, what it names
  fs::create_hard_link(file, to, failure);
  if (!failure) return {};
  fs::copy_file(file, to, failure);
  if (!failure) return {};
  return MakeError(ErrorCode::kUnavailable, "{}: cannot copy to {}: {}", from.string(), to.string(),
                   failure.message());
}

Result<void> CheckImportFolders(const fs::path& images, const fs::path& experience) {
  std::error_code ignored;
  const auto from = fs::weakly_canonical(images, ignored);
  const auto to = fs::weakly_canonical(experience, ignored);
  if (IsInside(to, from) || IsInside(from, to)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "{}: expected an experience folder apart from the images, found {}",
                     images.string(), experience.string());
  }
  if (!IsExperienceIdText(to.filename().string())) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "{}: expected a folder whose name can serve as the experience's id",
                     experience.string());
  }
  if (!fs::exists(to / "sensors" / "sensors.txt", ignored)) return {};
  return MakeError(ErrorCode::kConflict, "{}: expected no experience yet, found one",
                   experience.string());
}

}  // namespace waymark::mapping::internal

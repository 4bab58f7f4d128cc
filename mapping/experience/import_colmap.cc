// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/import_colmap.h"

#include <chrono>

#include "mapping/experience/internal/colmap_poses.h"
#include "mapping/experience/internal/imported_folder.h"
#include "mapping/experience/kapture.h"

namespace waymark::mapping {

namespace fs = std::filesystem;

Result<ColmapImport> ImportColmap(const fs::path& model_folder, const fs::path& image_folder,
                                  const fs::path& experience_folder) {
  WAYMARK_TRY(internal::CheckImportFolders(image_folder, experience_folder));
  WAYMARK_TRY_ASSIGN(const auto poses, internal::LoadColmapPoses(model_folder));
  ColmapImport import{.experience = {.id = ExperienceId("import"), .folder = experience_folder},
                      .missing = {}};
  Experience& experience = import.experience;
  for (const auto& [id, model] : poses.cameras) {
    const std::string name = fmt::format("cam{}", id);
    experience.cameras.emplace(name, CameraSensor{name, model, true});
  }
  std::int64_t second = 0;
  for (const internal::ColmapPoses::Image& image : poses.images) {
    std::error_code ignored;
    if (!fs::is_regular_file(image_folder / image.name, ignored)) {
      import.missing.push_back(image.name);
      continue;
    }
    const auto time = SensorTime(std::chrono::seconds(second++));
    const std::string camera = fmt::format("cam{}", image.camera);
    experience.images.push_back({time, camera, image.name});
    experience.trajectory.push_back({time, camera, image.camera_from_world});
  }
  if (experience.images.empty()) {
    return MakeError(ErrorCode::kNotFound, "{}: expected images of the model, such as {}",
                     image_folder.string(), poses.images.front().name);
  }
  for (const ImageRecord& image : experience.images) {
    WAYMARK_TRY(internal::PlaceImage(image_folder / image.name, experience_folder, image.name));
  }
  WAYMARK_TRY(StoreKapture(experience, experience_folder));
  WAYMARK_TRY_ASSIGN(import.experience, LoadKapture(experience_folder));
  return import;
}

}  // namespace waymark::mapping

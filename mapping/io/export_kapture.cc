// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/export_kapture.h"

#include <fmt/format.h>

#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"
#include "mapping/io/internal/export_images.h"

namespace waymark::mapping {
namespace {

Experience MakeExperience(std::span<const ExportSubmap> submaps) {
  Experience experience{.id = ExperienceId("map")};
  std::map<std::pair<std::size_t, std::uint32_t>, std::string> cameras;
  std::int64_t second = 0;
  for (const internal::ExportedImage& image : internal::MergeImages(submaps).images) {
    const ExportSubmap& submap = submaps[image.submap];
    const std::uint32_t camera = submap.images()[image.image].camera;
    const auto [entry, is_new] = cameras.try_emplace({image.submap, camera});
    if (is_new) {
      entry->second = fmt::format("submap{}_camera{}", image.submap, camera);
      experience.cameras.emplace(entry->second,
                                 CameraSensor{entry->second, submap.cameras()[camera], true});
    }
    const auto time = SensorTime(std::chrono::seconds(second++));
    experience.images.push_back({time, entry->second, image.name});
    experience.trajectory.push_back({time, entry->second, image.map_from_camera.Inverse().rigid()});
  }
  return experience;
}

std::string EncodePoints(std::span<const ExportSubmap> submaps) {
  std::string text = "# kapture format: 1.1\n# X, Y, Z, R, G, B\n";
  const auto out = std::back_inserter(text);
  for (const ExportSubmap& submap : submaps) {
    for (std::size_t i = 0; i < submap.landmark_count(); ++i) {
      const Eigen::Vector3d x = (submap.map_from_submap() * submap.Landmark(i)).coordinates();
      fmt::format_to(out, "{}, {}, {}, 128, 128, 128\n", x.x(), x.y(), x.z());
    }
  }
  return text;
}

}  // namespace

Result<void> StoreKaptureExport(std::span<const ExportSubmap> submaps,
                                const std::filesystem::path& folder) {
  WAYMARK_TRY(CreateFolders(folder / "reconstruction"));
  WAYMARK_TRY(StoreFileAtomically(folder / "reconstruction" / "points3d.txt",
                                  std::string_view(EncodePoints(submaps))));
  return StoreKapture(MakeExperience(submaps), folder);
}

}  // namespace waymark::mapping

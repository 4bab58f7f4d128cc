// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/data.h"

#include <algorithm>
#include <sstream>
#include <system_error>

#include "mapping/base/file.h"
#include "mapping/io/submap_file.h"
#include "mapping/store/map_directory.h"

namespace waymark::evaluation {
namespace {

namespace fs = std::filesystem;

// "timestamp, device, name": the last field, without its blanks.
std::string ImageNameOf(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(" \t", line.rfind(',') + 1);
  const std::size_t end = line.find_last_not_of(" \t\r") + 1;
  return line.substr(begin, end - begin);
}

}  // namespace

Result<void> LinkFile(const fs::path& target, const fs::path& link) {
  std::error_code error;
  fs::create_symlink(fs::absolute(target), link, error);
  if (!error) return {};
  return MakeError(ErrorCode::kUnavailable, "{}: {}", link.string(), error.message());
}

Result<std::set<std::string>> StoreKaptureSubset(const fs::path& from, const fs::path& to,
                                                 const ImageFilter& keep) {
  WAYMARK_TRY(CreateFolders(to / "sensors"));
  for (const auto& entry : fs::directory_iterator(from / "sensors")) {
    if (entry.path().filename() == "records_camera.txt") continue;
    WAYMARK_TRY(LinkFile(entry.path(), to / "sensors" / entry.path().filename()));
  }
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(from / "sensors/records_camera.txt"));
  std::set<std::string> kept;
  std::string subset;
  std::istringstream lines(text);
  std::string line;
  for (std::size_t index = 0; std::getline(lines, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (line.front() == '#') {
      subset += line + '\n';
      continue;
    }
    const std::string name = ImageNameOf(line);
    if (!keep(index++, name)) continue;
    subset += line + '\n';
    kept.insert(name);
  }
  WAYMARK_TRY(StoreFileAtomically(to / "sensors/records_camera.txt", std::string_view(subset)));
  return kept;
}

Result<MapPoses> LoadMapPoses(const fs::path& folder) {
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(folder));
  WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
  MapPoses poses;
  poses.submaps = release.submaps.size();
  for (const bool is_borrowed : {true, false}) {  // an image's own submap overrules
    for (const mapping::ReleasedSubmap& released : release.submaps) {
      WAYMARK_TRY_ASSIGN(const auto view,
                         mapping::SubmapView::Open(map.SubmapPath(released.id),
                                                   mapping::SubmapReading::kImagesOnly));
      std::size_t own = 0;
      for (const mapping::SubmapImage& image : view.images()) {
        own += !image.is_borrowed;
        if (image.is_borrowed != is_borrowed) continue;
        poses.map_from_camera[image.name] =
            CarryPose(released.map_from_submap, image.submap_from_camera).rigid();
      }
      poses.largest_submap = std::max(poses.largest_submap, own);
    }
  }
  return poses;
}

}  // namespace waymark::evaluation

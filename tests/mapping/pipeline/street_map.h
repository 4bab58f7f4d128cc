// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "mapping/io/submap_file.h"
#include "mapping/pipeline/pipeline.h"
#include "mapping/pipeline/removing.h"
#include "mapping/store/map_directory.h"
#include "tests/mapping/pipeline/facade.h"

namespace waymark::mapping {

/// Small drives along one street and maps made of them, in a folder that goes with the test.
class StreetMap {
 public:
  explicit StreetMap(const std::string& name)
      : folder_(std::filesystem::path(testing::TempDir()) / fmt::format("{}_{}", name, getpid())) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~StreetMap() { std::filesystem::remove_all(folder_); }
  StreetMap(const StreetMap&) = delete;
  StreetMap& operator=(const StreetMap&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path MapFolder(const std::string& map = "map") const { return folder_ / map; }
  MapDirectory Open(const std::string& map = "map") const {
    return *MapDirectory::Open(MapFolder(map));
  }

  FacadeTruth Drive(const std::string& name, const FacadeDriveOptions& options) const {
    return MakeFacadeDrive(folder_ / name, options);
  }

  AddRequest MakeAdd(const std::vector<std::string>& drives, const std::string& map = "map") const {
    AddRequest request{.map_folder = MapFolder(map), .created_utc = "2026-01-02T03:04:05Z"};
    for (const std::string& drive : drives) request.experience_folders.push_back(folder_ / drive);
    request.options.features.max_features = 700;
    return request;
  }
  Result<AddReport> Add(const std::vector<std::string>& drives,
                        const std::string& map = "map") const {
    return AddExperiences(MakeAdd(drives, map));
  }

  RemoveRequest MakeRemove(const std::string& map = "map") const {
    return {.map_folder = MapFolder(map), .created_utc = "2026-01-03T03:04:05Z"};
  }
  Result<RemoveReport> Remove(const std::string& drive, const std::string& map = "map") const {
    RemoveRequest request = MakeRemove(map);
    request.experiences.emplace_back(drive);
    return RemoveFromMap(request);
  }

  /// What is live, by experience that a submap was built from.
  std::multimap<std::string, SubmapId> Live(const std::string& map = "map") const {
    std::multimap<std::string, SubmapId> live;
    const MapDirectory directory = Open(map);
    const Release release = *directory.LoadCurrentRelease();
    for (const ReleasedSubmap& submap : release.submaps) {
      const auto view = *SubmapView::Open(directory.SubmapPath(submap.id));
      for (const SubmapImage& image : view.images()) {
        if (image.is_borrowed) continue;
        live.emplace(image.experience.text(), submap.id);
        break;
      }
    }
    return live;
  }

  /// Every file below a map's folder with its size.
  std::map<std::string, std::uintmax_t> Files(const std::string& map = "map") const {
    std::map<std::string, std::uintmax_t> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(MapFolder(map))) {
      if (!entry.is_regular_file()) continue;
      files[std::filesystem::relative(entry.path(), MapFolder(map)).string()] = entry.file_size();
    }
    return files;
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace waymark::mapping

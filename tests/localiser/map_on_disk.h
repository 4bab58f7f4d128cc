// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "mapping/io/submap_file.h"
#include "mapping/store/map_directory.h"

namespace waymark::localiser {

/// A map directory that lives as long as its test, filled submap by submap.
class MapOnDisk {
 public:
  MapOnDisk() : folder_(MakeFolder()), map_(*mapping::MapDirectory::Create(folder_, Describe())) {}
  ~MapOnDisk() { std::filesystem::remove_all(folder_.parent_path()); }
  MapOnDisk(const MapOnDisk&) = delete;
  MapOnDisk& operator=(const MapOnDisk&) = delete;

  const mapping::MapDirectory& map() const { return map_; }

  SubmapId Add(const mapping::SubmapModel& model, const Sim3& map_from_submap = Sim3(),
               double radius_m = 30) {
    const auto bytes = mapping::EncodeSubmap(model);
    CHECK(bytes.ok(), "{}", ToString(bytes.error()));
    const auto id = map_.StoreSubmap(*bytes);
    CHECK(id.ok(), "{}", ToString(id.error()));
    release_.submaps.push_back({.id = *id,
                                .map_from_submap = Similarity<Map, Submap>(map_from_submap),
                                .centre = Point<Map>(map_from_submap * Eigen::Vector3d::Zero()),
                                .radius_m = radius_m,
                                .overlap_rms_m = 0,
                                .gnss_rms_m = 0,
                                .displacement = std::nullopt});
    std::sort(release_.submaps.begin(), release_.submaps.end(),
              [](const auto& a, const auto& b) { return a.id < b.id; });
    return *id;
  }
  mapping::Release& release() { return release_; }
  const mapping::Release& release() const { return release_; }

 private:
  static std::filesystem::path MakeFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "waymark-map-XXXXXX").string();
    CHECK(mkdtemp(pattern.data()) != nullptr);
    return std::filesystem::path(pattern) / "map";
  }
  static mapping::MapDescription Describe() {
    return {.id = "8f0f5f1e-6d0a-4a53-9d54-0f4f2a1c7b11",
            .origin = {Angle::Degrees(37.77), Angle::Degrees(-122.42), 10},
            .is_geo_aligned = true,
            .options_json = "{}"};
  }

  std::filesystem::path folder_;
  mapping::MapDirectory map_;
  mapping::Release release_;
};

}  // namespace waymark::localiser

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/experience/experience.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::mapping {

/// An image as the map remembers it: everything building needs, without its pixels.
struct IndexedImage {
  std::string name = {};
  SensorTime time = {};
  std::uint32_t camera = 0;   ///< index into ExperienceIndex::cameras
  std::string features = {};  ///< file stem below features/: hash of the image and of the options
  std::optional<GeoPoint> gnss = {};  ///< of the camera, interpolated
  double gnss_sigma_m = 1;
  std::optional<Eigen::Vector3d> up_in_camera = {};
  /// By the gyroscope: the next image's camera from this one's; of the same camera, by time.
  std::optional<Eigen::Quaterniond> next_from_this = {};
};

/// Where a camera sits on its vehicle.
struct CameraMount {
  std::string rig;
  Rigid3 camera_from_rig;
};

/// An image that could not be used.
struct UnusableImage {
  std::string name;
  std::string reason;
};

/// MAP/experiences/<id>/index.json: an experience whose features are all in the map.
struct ExperienceIndex {
  ExperienceId id;
  std::string content = {};   ///< hash of every sensor table and image of the recording
  std::string features = {};  ///< hash of the options of its features
  std::vector<CameraSensor> cameras = {};
  std::vector<std::optional<CameraMount>> mounts = {};  ///< by camera
  std::vector<IndexedImage> images = {};                ///< by time
  std::vector<UnusableImage> unusable = {};
};

/// Pure codecs. Decoding errors: Corrupt, Unsupported, with `name` as the object.
std::string EncodeIndex(const ExperienceIndex& index);
Result<ExperienceIndex> DecodeIndex(std::string_view json, std::string_view name);

/// Where the parts of an experience lie below its folder in the map.
inline std::filesystem::path IndexPath(const std::filesystem::path& folder) {
  return folder / "index.json";
}
inline std::filesystem::path FeaturePath(const std::filesystem::path& folder,
                                         const std::string& stem) {
  return folder / "features" / (stem + ".feat");
}

Result<ExperienceIndex> LoadIndex(const std::filesystem::path& experience_folder);

}  // namespace waymark::mapping
